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

/// The truths of a scene's meshes, found and read before a run.
class References {
 public:
  References() = default;
  /// Those on another grid than the volume's are resampled onto it. Throws Error when one is missing or has no labels
  /// within the volume.
  References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume);

  /// What the reader had to assume and what was resampled, one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Labels on the volume's grid, under the path by which meshes name them; in place of those that had it.
  void add(const std::string& path, Volume labels) { labels_.insert_or_assign(path, std::move(labels)); }
  const std::map<std::string, Volume>& all() const { return labels_; }
  /// Whether the mesh names a reference that was read.
  bool has(const MeshItem& item) const { return item.reference && labels_.contains(item.reference->labels); }
  /// None without a reference.
  std::optional<Mask> mask_for(const MeshItem& item) const;

 private:
  std::map<std::string, Volume> labels_;  ///< by the path in the scene
  std::vector<std::string> warnings_;
};

}  // namespace simplexseg
