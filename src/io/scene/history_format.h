// SPDX-License-Identifier: Apache-2.0
// Constants and types shared by the writer and the reader of undo histories: docs/scene-format.md, "Undo history".
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "io/scene/pose_state.h"
#include "session/scene.h"
#include "session/scene_snapshot.h"

namespace simplexseg::history {

using Bytes = std::span<const std::uint8_t>;
using Arrays = SceneSnapshot::Arrays;
template <class T>
using Block = SceneSnapshot::Block<T>;

inline constexpr int kVersion = 1;
inline constexpr std::string_view kMagic = "simplexseg_history";
// CBOR bytes of a file, which is a list: the text kMagic, the head, the blocks, and the CRC-32 of all preceding bytes.
inline constexpr std::uint8_t kListHead = 0x9a, kBytesHead = 0x5b, kNumberHead = 0x1a;
inline constexpr std::uint8_t kMagicHead = 0x60 + kMagic.size();
inline constexpr std::size_t kBeforeHead = 5 + 1 + kMagic.size(), kCrcBytes = 5;

/// JSON that identifies the scene to which a history belongs: digests of the poses, and the numbers of points,
/// measurements and layers.
template <class Json>
Json owner_json(const Scene& scene) {
  Json owner = {{"poses", Json::array()}, {"points", scene.points.size()}};
  for (const MeshItem& item : scene.meshes) owner["poses"].push_back(pose_digest(item.mesh));
  if (!scene.measurements.empty()) owner["measurements"] = scene.measurements.size();
  if (!scene.layers.empty()) owner["layers"] = scene.layers.size();
  return owner;
}

}  // namespace simplexseg::history
