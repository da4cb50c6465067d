// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "image/mask.h"
#include "image/metrics.h"
#include "session/scene.h"

namespace simplexseg {

/// The truths of a scene's meshes, found and read before a run.
class References {
 public:
  References() = default;
  /// Throws Error when one is missing or on another grid than the volume's.
  References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume);

  /// Whether the mesh names a reference that was read.
  bool has(const MeshItem& item) const { return item.reference && labels_.contains(item.reference->labels); }
  /// None without a reference.
  std::optional<Mask> mask_for(const MeshItem& item) const;
  std::optional<Agreement> compare_with(const MeshItem& item) const;

 private:
  std::map<std::string, Volume> labels_;  ///< by the path in the scene
};

}  // namespace simplexseg
