// SPDX-License-Identifier: Apache-2.0
#include "io/scene/references.h"

#include <utility>

#include "core/error.h"
#include "image/mask.h"
#include "io/platform/data_path.h"

namespace simplexseg {

References::References(const Scene& scene, const std::filesystem::path& scene_folder, const VolumeGeometry& volume) {
  for (const MeshItem& item : scene.meshes) {
    if (!item.reference || labels_.contains(item.reference->labels)) continue;
    const std::filesystem::path path = find_data(item.reference->labels, scene_folder);
    auto file = std::make_shared<const LabelFile>(path);
    Volume labels = file->read_onto(volume, "the volume", warnings_);
    add(item.reference->labels, std::move(labels), std::move(file));
  }
}

void References::add(const std::string& path, Volume labels, std::shared_ptr<const LabelFile> file) {
  labels_.insert_or_assign(path, std::move(labels));
  overlapping_.erase(path);
  if (file && file->reads_alone()) overlapping_.emplace(path, std::move(file));
}

void References::add(const References& others) {
  for (const auto& [path, labels] : others.labels_) {
    const auto file = others.overlapping_.find(path);
    add(path, labels, file == others.overlapping_.end() ? nullptr : file->second);
  }
}

std::optional<Mask> References::mask_for(const MeshItem& item) const {
  if (!has(item)) return std::nullopt;
  const std::optional<double> label = item.reference->value;
  const Volume& all = labels_.at(item.reference->labels);
  if (const auto found = overlapping_.find(item.reference->labels); label && found != overlapping_.end()) {
    try {
      std::vector<std::string> known;  // warnings of the whole file were given when it was loaded
      return mask_of(found->second->read_onto(all.geometry(), "the volume", known, {.label = label}), label);
    } catch (const Error&) {  // the file has changed, or has no such label
    }
  }
  return mask_of(all, label);
}

}  // namespace simplexseg
