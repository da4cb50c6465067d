// SPDX-License-Identifier: Apache-2.0
// Client of the inference server of nnInteractive (https://github.com/MIC-DKFZ/nnInteractive, SERVER_CLIENT.md).
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "remote/array_message.h"
#include "remote/network_connection.h"
#include "remote/network_responses.h"

namespace simplexseg {
namespace {

using Json = nlohmann::json;

constexpr const char* kJson = "application/json";
constexpr const char* kBytes = "application/octet-stream";
constexpr std::uint64_t kMaxMask = std::uint64_t{1} << 31;

ArrayType array_type(VoxelType type) {
  constexpr ArrayType kTypes[] = {ArrayType::Int8,  ArrayType::UInt8,  ArrayType::Int16,   ArrayType::UInt16,
                                  ArrayType::Int32, ArrayType::UInt32, ArrayType::Float32, ArrayType::Float64};
  return kTypes[static_cast<int>(type)];
}

/// Lease of a session on the server. The destructor releases it.
class Lease {
 public:
  Lease(const NetworkServer& server, const NetworkConnection& connection) : server_(server), connection_(connection) {
    const NetworkLease lease =
        lease_of(connection.server(), connection.send({"POST", "/claim", kJson, {}, kJson, ""}).body);
    token_ = lease.token, beat_s_ = lease.beat_s;
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
  double beat_s_ = 0;
  mutable std::chrono::steady_clock::time_point last_beat_ = std::chrono::steady_clock::now();
};

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
  return info_of_capabilities(connection.server(), connection.send({"GET", "/capabilities", kJson, {}, "", ""}).body);
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
