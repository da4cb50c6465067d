// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_images.h"

#include <algorithm>
#include <set>
#include <string>

#include "core/digest.h"
#include "core/error.h"
#include "session/scene.h"
#include "session/scene_checks.h"
#include "session/scene_editor.h"

namespace simplexseg {
namespace {

std::optional<LayerItem> layer_with(const Scene& scene, ItemId id) {
  const LayerItem* const layer = id == 0 ? nullptr : scene.find_layer(id);
  return layer ? std::optional(*layer) : std::nullopt;
}

void add_text(Digest& digest, const std::string& text) {
  digest.add(text.size());
  digest.add(text.data(), text.size());
}

}  // namespace

bool MeshImages::uses(std::uint32_t image) const {
  return main == image || std::ranges::find(further, image) != further.end();
}

void check_images(const Scene& scene, const MeshImages& images, const std::string& name) {
  const std::string what = "the images of segmentation '" + name + "'";
  if (images.further.size() > kMostFurtherImages)
    throw Error(what, "there are more than " + std::to_string(kMostFurtherImages) + " further ones", "remove some");
  std::set<ItemId> all;
  const auto check = [&](ItemId id) {
    if (id != 0 && !scene.find_layer(id))
      throw Error(what, "the scene has no layer with the id " + std::to_string(id), "choose a layer of the scene");
    if (!all.insert(id).second) throw Error(what, "one of them is named twice", "name each image once");
  };
  check(images.main);
  for (const ItemId id : images.further) check(id);
}

LayersOfField layers_of(const Scene& scene, const MeshImages& images) {
  LayersOfField layers{layer_with(scene, images.main), {}};
  for (const ItemId id : images.further) layers.further.push_back(layer_with(scene, id));
  return layers;
}

std::uint64_t digest_of(const std::optional<LayerItem>& layer) {
  if (!layer) return 0;
  Digest digest;
  if (layer->checksum.empty()) {
    add_text(digest, layer->path);
    add_text(digest, layer->series);
    digest.add(layer->number);
  } else {
    add_text(digest, layer->checksum);
  }
  add_text(digest, layer->transform.checksum);
  digest.add(layer->transform.affine.matrix().data(), 16);
  add_text(digest, key_of(layer->preprocessing.filters));
  return digest.value();
}

std::uint64_t digest_of(const Scene& scene, const MeshImages& images) {
  if (images.is_default()) return 0;
  const LayersOfField layers = layers_of(scene, images);
  Digest digest;
  digest.add(digest_of(layers.main));
  for (const std::optional<LayerItem>& layer : layers.further) digest.add(digest_of(layer));
  return digest.value();
}

SceneChange SceneEditor::execute(const SetImages& command) {
  MeshItem& item = item_of(command.mesh);
  refuse_locked(item);
  check_images(scene_, command.images, item.name);
  if (item.is_given() && !command.images.is_default())
    throw Error("segmentation '" + item.name + "'", "it starts from labels or a mesh, so its field uses no image",
                "start it from a seed to choose its images");
  item.images = command.images;
  item.cancelled = nullptr;
  return {EngineUpdate::Nothing};
}

}  // namespace simplexseg
