// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "session/scene.h"

namespace simplexseg {

/// Reference segmentations of the meshes of a scene, loaded before a run.
class References {
 public:
  References() = default;
  /// Reads the references of all meshes and resamples them onto the grid of the volume if necessary. Throws Error if a
  /// file is missing or cannot be read, or has no labels within the volume.
  References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume);

  /// Warnings of the readers and of the resampling, one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Adds labels on the grid of the volume; replaces labels with the same path. `path`: path stored in the meshes.
  void add(const std::string& path, Volume labels) { labels_.insert_or_assign(path, std::move(labels)); }
  const std::map<std::string, Volume>& all() const { return labels_; }
  /// Whether the reference of a mesh is loaded.
  bool has(const MeshItem& item) const { return item.reference && labels_.contains(item.reference->labels); }
  /// Mask of the reference of a mesh; nullopt if it is not loaded.
  std::optional<Mask> mask_for(const MeshItem& item) const;

 private:
  std::map<std::string, Volume> labels_;  ///< key: path stored in the scene
  std::vector<std::string> warnings_;
};

}  // namespace simplexseg
