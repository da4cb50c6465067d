// SPDX-License-Identifier: Apache-2.0
// Client of MONAI Label (https://github.com/Project-MONAI/MONAILabel, its REST interface).
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/temporary_folder.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"
#include "remote/network_connection.h"
#include "remote/network_responses.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr const char* kJson = "application/json";
constexpr const char* kPartStart = "--simplexseg-2f6c0e17a94b4d58\r\nContent-Disposition: form-data; name=\"";
constexpr const char* kFormEnd = "--simplexseg-2f6c0e17a94b4d58--\r\n";
constexpr const char* kFormType = "multipart/form-data; boundary=simplexseg-2f6c0e17a94b4d58";
constexpr std::uint64_t kMaxLabels = std::uint64_t{1} << 31;

std::string file_bytes(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Part of a form. `file`: name of its file; empty: a field.
std::string form_part(const std::string& name, const std::string& file, const std::string& content) {
  std::string part = kPartStart + name + "\"";
  if (!file.empty()) part += "; filename=\"" + file + "\"\r\nContent-Type: application/octet-stream";
  return part + "\r\n\r\n" + content + "\r\n";
}

/// Session with an image on the server. The destructor deletes it there.
class ImageSession {
 public:
  ImageSession(const NetworkServer& server, const NetworkConnection& connection, const std::string& image)
      : server_(server) {
    const std::string body = form_part("files", "image.nii.gz", image) + kFormEnd;
    const HttpResponse response = connection.send({"PUT", "/session/", kJson, {}, kFormType, body});
    id_ = session_of(connection.server(), response.body);
  }
  ~ImageSession() {
    try {
      NetworkServer quick = server_;
      quick.timeout_s = std::min(quick.timeout_s, 5);
      const HttpClient http(web_server_of(quick));
      http.send({"DELETE", "/session/" + url_escaped(id_), kJson, {}, "", ""}, [] {});
    } catch (const Error&) {  // the server deletes old sessions by itself
    }
  }
  ImageSession(const ImageSession&) = delete;
  ImageSession& operator=(const ImageSession&) = delete;
  const std::string& id() const { return id_; }

 private:
  const NetworkServer& server_;
  std::string id_;
};

Json points_of(const std::vector<VoxelIndex>& voxels) {
  Json points = Json::array();
  for (const VoxelIndex& at : voxels) points.push_back({at[0], at[1], at[2]});
  return points;
}

/// Mask of the label of the seed in a label image on this grid.
Mask mask_at_seed(const Volume& labels, const VolumeGeometry& grid, const VoxelIndex& seed) {
  const double label = labels.value(seed[0], seed[1], seed[2]);
  Mask mask = mask_of(labels, label != 0 ? std::optional(label) : std::nullopt);
  mask.geometry = grid;
  return mask;
}

}  // namespace

std::optional<NetworkInfo> monai_label_info(const NetworkConnection& connection) {
  const HttpResponse response = connection.probe({"GET", "/info/", kJson, {}, "", ""});
  if (response.status == 401 || response.status == 403) connection.send({"GET", "/info/", kJson, {}, "", ""});
  return response.status == 200 ? info_of_models(response.body) : std::nullopt;
}

Mask monai_label_mask(const NetworkServer& server, const NetworkConnection& connection, const NetworkRequest& request) {
  const TemporaryFolder folder;
  const fs::path image = folder.path() / "image.nii.gz", labels_file = folder.path() / "mask.nii.gz";
  write_volume(image, request.volume);
  const ImageSession session(server, connection, file_bytes(image));
  const Json params = {{"foreground", points_of(request.prompts.inside)},
                       {"background", points_of(request.prompts.outside)},
                       {"result_extension", ".nii.gz"}};
  const std::string path =
      "/infer/" + url_escaped(request.network) + "?session_id=" + url_escaped(session.id()) + "&output=image";
  const HttpResponse response = connection.send(
      {"POST", path, "*/*", {}, kFormType, form_part("params", "", params.dump()) + kFormEnd, kMaxLabels});
  {
    std::ofstream stream(labels_file, std::ios::binary);
    stream.write(response.body.data(), static_cast<std::streamsize>(response.body.size()));
    if (!stream.flush())
      throw Error("the mask of a network", "it cannot be stored", "free space in " + quoted(folder.path()));
  }
  const VolumeGeometry& grid = request.volume.geometry();
  Volume labels;
  try {
    const VolumeSource source = open_volume(labels_file);
    if (!source.info.geometry.same_grid(grid))  // before memory is allocated for its voxels
      throw remote_fault(connection.server(), "its mask has another grid than the image",
                         "use a network that keeps the grid");
    labels = load_volume(source, labels_file).volume;
  } catch (const RemoteFault&) {
    throw;
  } catch (const Error& error) {
    throw remote_fault(connection.server(), "its mask cannot be read: " + one_line(error.what(), 200),
                       "check its version");
  }
  return mask_at_seed(labels, grid, request.prompts.inside.front());
}

}  // namespace simplexseg
