// SPDX-License-Identifier: Apache-2.0
#include "remote/network_responses.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.h"
#include "io/platform/files.h"
#include "remote/array_message.h"

namespace simplexseg {
namespace {

using Json = nlohmann::json;

constexpr const char* kNoLicence = "!!MISSING!!";  ///< licence that the server of nnInteractive does not know
constexpr int kScribbleVoxels = 2;                 ///< thickness of scribbles for a server that does not state it

RemoteFault bad_response(const WebServer& server, const std::string& why) {
  return remote_fault(server, "its response is damaged: " + why, "try again, or check its version");
}

Json json_of(const WebServer& server, const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw bad_response(server, "it is not a JSON object");
  return json;
}

/// Text of a key; "" without one.
std::string text_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}
/// Whether a key has this value.
bool has(const Json& json, const char* key, bool value) {
  const auto found = json.find(key);
  return found != json.end() && *found == value;
}

/// Thickness of scribbles that a server prefers, a number or one for each axis, voxels.
int scribble_voxels(const Json& claims) {
  const auto preferred = claims.find("preferred_scribble_thickness");
  if (preferred == claims.end()) return kScribbleVoxels;
  const Json& one = preferred->is_array() && !preferred->empty() ? preferred->front() : *preferred;
  return one.is_number() ? static_cast<int>(std::clamp(one.get<double>(), 1.0, 20.0)) : kScribbleVoxels;
}

/// Range [first, end) of an axis of the image with `size` voxels.
struct Range {
  std::int64_t first = 0, size = 0;
};
Range range_of(const WebServer& server, const Json& json, std::int64_t size) {
  const bool valid = json.is_array() && json.size() == 2 && json[0].is_number_integer() && json[1].is_number_integer();
  if (!valid) throw bad_response(server, "its region is not three ranges");
  const auto first = json[0].get<std::int64_t>(), end = json[1].get<std::int64_t>();
  if (first < 0 || end <= first || end > size) throw bad_response(server, "its region lies outside the image");
  return {first, end - first};
}

}  // namespace

std::string stated(const std::string& text) { return one_line(text, 200); }

std::string detail_of(const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  return json.is_object() ? stated(text_of(json, "detail")) : "";
}

NetworkLease lease_of(const WebServer& server, const std::string& body) {
  const Json claim = json_of(server, body);
  NetworkLease lease;
  if (!claim.contains("lease_token") || !claim["lease_token"].is_string())
    throw bad_response(server, "it has no lease");
  lease.token = claim["lease_token"].get<std::string>();
  if (lease.token.empty() || lease.token.size() > 200 ||
      !std::ranges::all_of(lease.token, [](unsigned char c) { return c > 0x20 && c < 0x7f; }))
    throw bad_response(server, "its lease is not a text");
  if (const auto limit = claim.find("liveness_timeout_seconds"); limit != claim.end() && limit->is_number())
    lease.beat_s = std::clamp(limit->get<double>() / 2, 0.5, 600.0);
  return lease;
}

NetworkInfo info_of_capabilities(const WebServer& server, const std::string& body) {
  const Json claims = json_of(server, body);
  NetworkInfo info;
  info.networks = {"nnInteractive"};
  if (const std::string licence = text_of(claims, "license"); licence != kNoLicence) info.licence = stated(licence);
  if (const auto kinds = claims.find("supported_interactions"); kinds != claims.end() && kinds->is_object()) {
    for (const auto& [name, supported] : kinds->items())
      if (supported == true) info.inputs.push_back(stated(name));
    if (has(*kinds, "points", false))
      throw remote_fault(server, "its network does not accept points", "load another network there");
    if (has(*kinds, "scribble", true)) info.scribble_voxels = scribble_voxels(claims);
  }
  return info;
}

void take_region(const WebServer& server, const HttpResponse& response, Mask& mask) {
  const Json meta = json_of(server, response.meta);
  if (!has(meta, "ran_prediction", true)) throw bad_response(server, "there was no prediction");
  if (!meta.contains("bbox") || meta["bbox"].is_null()) return;  // no voxel changed
  const Json& box = meta["bbox"];
  if (!box.is_array() || box.size() != 3) throw bad_response(server, "its region is not three ranges");
  std::array<Range, 3> ranges;
  for (std::size_t a = 0; a < 3; ++a) ranges[a] = range_of(server, box[a], mask.geometry.size[2 - a]);
  const auto [k_range, j_range, i_range] = ranges;
  ArrayMessage array;
  try {
    array = unpack_array(response.body, 8 * static_cast<std::uint64_t>(k_range.size * j_range.size * i_range.size));
  } catch (const Error& error) {
    throw bad_response(server, error.what());
  }
  if (array.shape != std::vector<std::int64_t>{k_range.size, j_range.size, i_range.size})
    throw bad_response(server, "its mask has not the shape of its region");
  if (bytes_of(array.type) != 1)
    throw bad_response(server, std::string("its mask has the type ") + name_of(array.type));
  const std::byte* from = array.bytes.data();
  for (std::int64_t k = 0; k < k_range.size; ++k)
    for (std::int64_t j = 0; j < j_range.size; ++j) {
      const std::int64_t row = (k_range.first + k) * mask.geometry.size[1] + j_range.first + j;
      std::uint8_t* const to = &mask.voxels[static_cast<std::size_t>(row * mask.geometry.size[0] + i_range.first)];
      for (std::int64_t i = 0; i < i_range.size; ++i) to[i] = *from++ != std::byte{0};
    }
}

std::optional<NetworkInfo> info_of_models(const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object() || !json.contains("models") || !json["models"].is_object()) return std::nullopt;
  NetworkInfo info;
  info.protocol = NetworkInfo::Protocol::MonaiLabel;
  std::vector<std::string> others;
  for (const auto& [name, model] : json["models"].items()) {
    const std::string type = model.is_object() ? text_of(model, "type") : "";
    const bool uses_points = type == "deepgrow" || type == "deepedit" || type.starts_with("vista");
    (uses_points ? info.networks : others).push_back(stated(name));
  }
  info.networks.insert(info.networks.end(), others.begin(), others.end());
  info.inputs = {"points"};
  info.licence = stated(text_of(json, "license"));
  return info;
}

std::string session_of(const WebServer& server, const std::string& body) {
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object() || !json.contains("session_id") || !json["session_id"].is_string())
    throw remote_fault(server, "its response has no session", "check its version");
  return json["session_id"].get<std::string>();
}

}  // namespace simplexseg
