// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "io/labels/label_file.h"
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
  /// `file`: file of the labels, from which a chosen label is read again if others can share its voxels; may be null.
  void add(const std::string& path, Volume labels, std::shared_ptr<const LabelFile> file = nullptr);
  /// Adds the labels of other references.
  void add(const References& others);
  const std::map<std::string, Volume>& all() const { return labels_; }
  /// Whether the reference of a mesh is loaded.
  bool has(const MeshItem& item) const { return item.reference && labels_.contains(item.reference->labels); }
  /// Mask of the reference of a mesh; nullopt if it is not loaded. A label that can share voxels with others is read
  /// from its file; if that fails, the voxels of the loaded labels are used.
  std::optional<Mask> mask_for(const MeshItem& item) const;

 private:
  std::map<std::string, Volume> labels_;  ///< key: path stored in the scene
  /// Files whose labels can share voxels, so that a chosen label is read alone; key: path stored in the scene.
  std::map<std::string, std::shared_ptr<const LabelFile>> overlapping_;
  std::vector<std::string> warnings_;
};

}  // namespace simplexseg
