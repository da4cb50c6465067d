// SPDX-License-Identifier: Apache-2.0
#include "session/layer.h"

#include <array>
#include <cmath>

#include "core/error.h"
#include "session/scene_editor.h"

namespace simplexseg {
namespace {

constexpr std::array<ColourMapInfo, 5> kColourMaps{{{ColourMap::Grey, "grey", "Grey"},
                                                    {ColourMap::InvertedGrey, "inverted_grey", "Inverted grey"},
                                                    {ColourMap::Hot, "hot", "Hot"},
                                                    {ColourMap::Green, "green", "Green"},
                                                    {ColourMap::Magenta, "magenta", "Magenta"}}};
constexpr double kLargestValue = 1e30, kLargestMatrixElement = 1e9;

}  // namespace

std::span<const ColourMapInfo> colour_maps() { return kColourMaps; }

const ColourMapInfo& info_of(ColourMap map) { return kColourMaps.at(static_cast<std::size_t>(map)); }

std::optional<ColourMap> find_colour_map(const std::string& name) {
  for (const ColourMapInfo& info : kColourMaps)
    if (name == info.name) return info.map;
  return std::nullopt;
}

void check_layer(const LayerItem& layer) {
  const std::string what = "layer '" + layer.name + "'";
  if (layer.name.empty()) throw Error("a layer", "its name is empty", "choose a name");
  if (layer.path.empty()) throw Error(what, "it has no file", "choose the file of an image");
  if (layer.number < 1) throw Error(what, "volumes of a 4D file are numbered from 1", "correct the number");
  const auto in_range = [](double value) { return std::isfinite(value) && std::abs(value) <= kLargestValue; };
  check_preprocessing(layer.preprocessing);
  if (!(layer.scale > 0) || !in_range(layer.scale))
    throw Error(what, "its scale is not a finite number above 0", "correct it");
  if (!(layer.opacity >= 0 && layer.opacity <= 1)) throw Error(what, "its opacity is out of range", "give 0 to 1");
  if (!(layer.window > 0) || !in_range(layer.window) || !in_range(layer.level))
    throw Error(what, "its window and level are not finite, or the window is not above 0", "correct them");
  const Eigen::Matrix<double, 3, 4> matrix = layer.transform.affine.matrix().topRows<3>();
  if (!matrix.allFinite() || matrix.cwiseAbs().maxCoeff() > kLargestMatrixElement ||
      layer.transform.affine.linear().determinant() == 0)
    throw Error(what, "its transform is not an invertible affine map", "correct or remove it");
}

// ---- commands ----

LayerItem& SceneEditor::layer_of(ItemId layer) {
  for (LayerItem& one : scene_.layers)
    if (one.id == layer) return one;
  throw Error("layer " + std::to_string(layer), "there is no such layer", "choose one of the scene");
}

SceneChange SceneEditor::execute(const AddLayer& command) {
  check_layer(command.item);
  scene_.layers.push_back(command.item);
  scene_.layers.back().id = next_id_++;
  return {EngineUpdate::Nothing, scene_.layers.back().id};
}

SceneChange SceneEditor::execute(const EditLayer& command) {
  LayerItem& layer = layer_of(command.layer);
  LayerItem edited = layer;
  edited.name = command.name.value_or(edited.name);
  edited.preprocessing = command.preprocessing.value_or(edited.preprocessing);
  edited.transform = command.transform.value_or(edited.transform);
  edited.colour_map = command.colour_map.value_or(edited.colour_map);
  edited.opacity = command.opacity.value_or(edited.opacity);
  edited.window = command.window.value_or(edited.window);
  edited.level = command.level.value_or(edited.level);
  edited.visible = command.visible.value_or(edited.visible);
  check_layer(edited);
  layer = std::move(edited);
  return {EngineUpdate::Nothing};
}

SceneChange SceneEditor::execute(const RemoveLayer& command) {
  const LayerItem& layer = layer_of(command.layer);
  for (const MeshItem& item : scene_.meshes)
    if (item.images.uses(layer.id))
      throw Error("layer '" + layer.name + "'", "segmentation '" + item.name + "' is computed with it",
                  "choose other images of that segmentation first");
  std::erase_if(scene_.layers, [&](const LayerItem& one) { return one.id == command.layer; });
  return {EngineUpdate::Nothing};
}

}  // namespace simplexseg
