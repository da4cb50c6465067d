// SPDX-License-Identifier: Apache-2.0
// Client of the inference server of nnInteractive (https://github.com/MIC-DKFZ/nnInteractive, SERVER_CLIENT.md).
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "remote/array_message.h"
#include "remote/network_connection.h"

namespace simplexseg {
namespace {

using Json = nlohmann::json;

constexpr const char* kJson = "application/json";
constexpr const char* kBytes = "application/octet-stream";
constexpr const char* kNoLicence = "!!MISSING!!";  ///< licence that the server does not know
constexpr int kScribbleVoxels = 2;                 ///< thickness of scribbles for a server that does not state it
constexpr std::uint64_t kMaxMask = std::uint64_t{1} << 31;

ArrayType array_type(VoxelType type) {
  constexpr ArrayType kTypes[] = {ArrayType::Int8,  ArrayType::UInt8,  ArrayType::Int16,   ArrayType::UInt16,
                                  ArrayType::Int32, ArrayType::UInt32, ArrayType::Float32, ArrayType::Float64};
  return kTypes[static_cast<int>(type)];
}

RemoteFault bad_response(const WebServer& server, const std::string& why) {
  return remote_fault(server, "its response is damaged: " + why, "try again, or check its version");
}

Json json_of(const WebServer& server, const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw bad_response(server, "it is not a JSON object");
  return json;
}

/// Lease of a session on the server. The destructor releases it.
class Lease {
 public:
  Lease(const NetworkServer& server, const NetworkConnection& connection) : server_(server), connection_(connection) {
    const Json claim = json_of(connection.server(), connection.send({"POST", "/claim", kJson, {}, kJson, ""}).body);
    if (!claim.contains("lease_token") || !claim["lease_token"].is_string())
      throw bad_response(connection.server(), "it has no lease");
    token_ = claim["lease_token"].get<std::string>();
    if (token_.empty() || token_.size() > 200 ||
        !std::ranges::all_of(token_, [](unsigned char c) { return c > 0x20 && c < 0x7f; }))
      throw bad_response(connection.server(), "its lease is not a text");
    if (const auto limit = claim.find("liveness_timeout_seconds"); limit != claim.end() && limit->is_number())
      beat_s_ = std::clamp(limit->get<double>() / 2, 0.5, 600.0);
  }
  ~Lease() {
    try {
      NetworkServer quick = server_;
      quick.timeout_s = std::min(quick.timeout_s, 5);
      const HttpClient http(web_server_of(quick));
      http.send({"POST", "/release", kJson, headers(), kJson, ""}, [] {});
    } catch (const Error&) {  // the server ends the session by itself
    }
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  HttpResponse post(const std::string& path, const Json& body) const {
    return send({"POST", path, "*/*", headers(), kJson, body.dump(), kMaxMask});
  }
  HttpResponse post_array(const std::string& path, const Json& meta, std::string array) const {
    HttpRequest request{"POST", path, "*/*", headers(), kBytes, std::move(array), kMaxMask};
    request.headers.emplace_back("X-Meta", meta.dump());
    return send(request);
  }

 private:
  std::vector<std::pair<std::string, std::string>> headers() const { return {{"X-Lease-Token", token_}}; }

  /// Sends a request, and heartbeats while it waits.
  HttpResponse send(const HttpRequest& request) const {
    return connection_.send(request, [this] {
      connection_.wait();
      const auto now = std::chrono::steady_clock::now();
      if (std::chrono::duration<double>(now - last_beat_).count() < beat_s_) return;
      last_beat_ = now;
      try {
        connection_.probe({"POST", "/heartbeat", kJson, headers(), kJson, ""});
      } catch (const RemoteFault&) {  // the request itself reports a lost connection
      }
    });
  }

  const NetworkServer& server_;
  const NetworkConnection& connection_;
  std::string token_;
  double beat_s_ = 20;
  mutable std::chrono::steady_clock::time_point last_beat_ = std::chrono::steady_clock::now();
};

/// Writes the region of a response into a mask. The axes of arrays are k, j, i, as in the memory of the image.
void take_region(const WebServer& server, const HttpResponse& response, Mask& mask) {
  const Json meta = json_of(server, response.meta);
  if (!meta.value("ran_prediction", false)) throw bad_response(server, "there was no prediction");
  if (!meta.contains("bbox") || meta["bbox"].is_null()) return;  // no voxel changed
  const Json& box = meta["bbox"];
  std::array<std::int64_t, 3> low{}, size{};
  for (std::size_t a = 0; a < 3; ++a) {
    const bool valid = box.is_array() && box.size() == 3 && box[a].is_array() && box[a].size() == 2 &&
                       box[a][0].is_number_integer() && box[a][1].is_number_integer();
    if (!valid) throw bad_response(server, "its region is not three ranges");
    low[a] = box[a][0].get<std::int64_t>(), size[a] = box[a][1].get<std::int64_t>() - low[a];
    if (low[a] < 0 || size[a] <= 0 || size[a] > mask.geometry.size[2 - a] ||
        low[a] > mask.geometry.size[2 - a] - size[a])
      throw bad_response(server, "its region lies outside the image");
  }
  const auto voxels = static_cast<std::uint64_t>(size[0] * size[1] * size[2]);
  ArrayMessage array;
  try {
    array = unpack_array(response.body, 8 * voxels);
  } catch (const Error& error) {
    throw bad_response(server, error.what());
  }
  if (array.shape != std::vector<std::int64_t>(size.begin(), size.end()))
    throw bad_response(server, "its mask has not the shape of its region");
  if (bytes_of(array.type) != 1)
    throw bad_response(server, std::string("its mask has the type ") + name_of(array.type));
  const std::byte* from = array.bytes.data();
  for (std::int64_t k = 0; k < size[0]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j) {
      std::uint8_t* const to =
          &mask.voxels[((low[0] + k) * mask.geometry.size[1] + low[1] + j) * mask.geometry.size[0] + low[2]];
      for (std::int64_t i = 0; i < size[2]; ++i) to[i] = *from++ != std::byte{0};
    }
}

/// Thickness of scribbles that a server prefers, a number or one for each axis, voxels.
int scribble_voxels(const Json& claims) {
  const auto preferred = claims.find("preferred_scribble_thickness");
  if (preferred == claims.end()) return kScribbleVoxels;
  const Json& one = preferred->is_array() && !preferred->empty() ? preferred->front() : *preferred;
  return one.is_number() ? static_cast<int>(std::clamp(one.get<double>(), 1.0, 20.0)) : kScribbleVoxels;
}

std::string packed_scribble(const StrokeVoxels& voxels) {
  const std::vector<std::int64_t> shape = {voxels.box.size[2], voxels.box.size[1], voxels.box.size[0]};
  std::vector<std::byte> set;
  set.reserve(voxels.voxels.size());
  for (const VoxelPaint voxel : voxels.voxels) set.push_back(std::byte{voxel != VoxelPaint::None});
  return pack_array(ArrayType::UInt8, shape, set);
}

}  // namespace

std::optional<NetworkInfo> nninteractive_info(const NetworkConnection& connection) {
  const HttpResponse health = connection.probe({"GET", "/healthz", kJson, {}, "", ""});
  const Json state = Json::parse(health.body, nullptr, false);
  if (health.status != 200 || !state.is_object() || !state.contains("ok")) return std::nullopt;
  const Json claims = json_of(connection.server(), connection.send({"GET", "/capabilities", kJson, {}, "", ""}).body);
  NetworkInfo info;
  info.networks = {"nnInteractive"};
  if (const auto licence = claims.find("license"); licence != claims.end() && licence->is_string())
    if (*licence != kNoLicence) info.licence = stated(licence->get<std::string>());
  if (const auto kinds = claims.find("supported_interactions"); kinds != claims.end() && kinds->is_object()) {
    for (const auto& [name, supported] : kinds->items())
      if (supported == true) info.inputs.push_back(stated(name));
    const auto states = [&](const char* kind, bool supported) {
      const auto found = kinds->find(kind);
      return found != kinds->end() && *found == supported;
    };
    if (states("points", false))
      throw remote_fault(connection.server(), "its network does not accept points", "load another network there");
    if (states("scribble", true)) info.scribble_voxels = scribble_voxels(claims);
  }
  return info;
}

Mask nninteractive_mask(const NetworkServer& server, const NetworkConnection& connection,
                        const NetworkRequest& request) {
  const VolumeGeometry& grid = request.volume.geometry();
  const std::vector<std::int64_t> shape = {1, grid.size[2], grid.size[1], grid.size[0]};
  const auto* const voxels = static_cast<const std::byte*>(request.volume.data());
  Mask mask{grid, std::vector<std::uint8_t>(grid.voxel_count())};
  std::string image = pack_array(array_type(request.volume.type()), shape, {voxels, request.volume.bytes()});
  const Lease lease(server, connection);
  const Json spacing = {grid.spacing_mm[2], grid.spacing_mm[1], grid.spacing_mm[0]};
  lease.post_array("/set_image", {{"image_properties", {{"spacing", spacing}}}}, std::move(image));
  lease.post("/set_target_buffer", {{"shape", {shape[1], shape[2], shape[3]}}, {"dtype", "uint8"}});
  // The network computes once, after the last prompt: an inside point, since there is a seed.
  const NetworkPrompts& prompts = request.prompts;
  std::size_t left = prompts.inside.size() + prompts.outside.size() + prompts.scribbles.size();
  HttpResponse last;
  for (const bool inside : {false, true}) {
    const auto keys = [&] {
      return Json{
          {"include_interaction", inside}, {"run_prediction", --left == 0}, {"override_capability_checks", false}};
    };
    for (const NetworkScribble& scribble : prompts.scribbles) {
      if (scribble.inside != inside) continue;
      Json meta = keys();
      for (std::size_t a = 3; a-- > 0;) {
        const int low = scribble.voxels.box.first[a];
        meta["interaction_bbox"].push_back({low, low + scribble.voxels.box.size[a]});
      }
      last = lease.post_array("/add_scribble_interaction", meta, packed_scribble(scribble.voxels));
    }
    for (const VoxelIndex& at : inside ? prompts.inside : prompts.outside) {
      Json body = keys();
      body["coordinates"] = {at[2], at[1], at[0]};
      last = lease.post("/add_point_interaction", body);
    }
  }
  take_region(connection.server(), last, mask);
  return mask;
}

}  // namespace simplexseg
