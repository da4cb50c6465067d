// SPDX-License-Identifier: Apache-2.0
#include "io/references.h"

#include "image/mask.h"
#include "image/rasterise.h"
#include "io/data_path.h"
#include "io/files.h"
#include "io/labels_io.h"
#include "io/volume_io.h"

namespace simplexseg {

References::References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume) {
  for (const MeshItem& item : scene.meshes) {
    if (!item.reference || labels_.contains(item.reference->labels)) continue;
    const std::filesystem::path path = find_data(item.reference->labels, scene_folder);
    LoadedVolume loaded = load_volume(path);
    for (const std::string& warning : loaded.warnings) warnings_.push_back(quoted(path) + ": " + warning);
    Volume labels = onto_grid(loaded.volume, volume, path, "the volume", warnings_);
    labels_.emplace(item.reference->labels, std::move(labels));
  }
}

std::optional<Mask> References::mask_for(const MeshItem& item) const {
  if (!has(item)) return std::nullopt;
  return mask_of(labels_.at(item.reference->labels), item.reference->value);
}

std::optional<Agreement> References::compare_with(const MeshItem& item) const {
  const std::optional<Mask> mask = mask_for(item);
  if (!mask) return std::nullopt;
  return compare(*mask, rasterise(item.mesh, mask->geometry));
}

}  // namespace simplexseg
