// SPDX-License-Identifier: Apache-2.0
#include "io/scene/references.h"

#include "image/mask.h"
#include "io/labels/labels_io.h"
#include "io/platform/data_path.h"

namespace simplexseg {

References::References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume) {
  for (const MeshItem& item : scene.meshes) {
    if (!item.reference || labels_.contains(item.reference->labels)) continue;
    const std::filesystem::path path = find_data(item.reference->labels, scene_folder);
    labels_.emplace(item.reference->labels, load_labels_onto(path, volume, "the volume", warnings_));
  }
}

std::optional<Mask> References::mask_for(const MeshItem& item) const {
  if (!has(item)) return std::nullopt;
  return mask_of(labels_.at(item.reference->labels), item.reference->value);
}

}  // namespace simplexseg
