// SPDX-License-Identifier: Apache-2.0
// Layers in scene files and logs, and filters in logs (docs/scene-format.md).
#pragma once
#include <concepts>
#include <filesystem>
#include <functional>
#include <string>

#include "io/scene/preprocessing_text.h"
#include "session/command.h"

namespace simplexseg {

class JsonInput;

template <class C>
concept LayerCommand = std::same_as<C, AddLayer> || std::same_as<C, EditLayer> || std::same_as<C, RemoveLayer> ||
    std::same_as<C, FilterVolume> || std::same_as<C, SetImages>;

/// JSON of a transform of a layer. `file`: path to store instead of that of the transform.
template <class Json>
Json layer_transform_json(const LayerTransform& transform, const std::string& file) {
  Json json = Json::object();
  if (!transform.file.empty()) json["file"] = file, json["checksum"] = transform.checksum;
  if (transform.affine.matrix().isIdentity(0)) return json;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) json["affine"].push_back(transform.affine(row, column));
  return json;
}

/// JSON of a layer, without its id. `stored`: path to store for the path of the image or the transform.
template <class Json>
Json layer_json(const LayerItem& layer, const std::function<std::string(const std::string&)>& stored) {
  Json json = {{"name", layer.name}, {"image", stored(layer.path)}};
  if (layer.number != 1) json["volume_number"] = layer.number;
  if (!layer.series.empty()) json["series"] = layer.series;
  if (!layer.checksum.empty()) json["checksum"] = layer.checksum;
  if (layer.scale != 1) json["scale"] = layer.scale;
  if (!layer.unit.empty()) json["unit"] = layer.unit;
  if (!layer.preprocessing.filters.empty()) json["preprocessing"] = preprocessing_json<Json>(layer.preprocessing);
  if (!layer.transform.is_identity())
    json["transform"] = layer_transform_json<Json>(layer.transform, stored(layer.transform.file));
  json["colour_map"] = info_of(layer.colour_map).name;
  json["opacity"] = layer.opacity;
  json["window"] = layer.window;
  json["level"] = layer.level;
  if (!layer.visible) json["visible"] = false;
  return json;
}
/// Layer from the JSON of layer_json(); its files are not read. Relative paths of files in `folder` become absolute.
/// Throws Error for an unknown key and for values that check_layer() refuses.
LayerItem layer_from_json(const JsonInput& input, const std::filesystem::path& folder);

/// JSON of the images of a mesh. `number_of`: number to store for the id of a layer; 0 is the volume.
template <class Json>
Json images_json(const MeshImages& images, const std::function<ItemId(ItemId)>& number_of) {
  Json json = {{"main", number_of(images.main)}};
  for (const ItemId id : images.further) json["further"].push_back(number_of(id));
  return json;
}
/// Images from the JSON of images_json(), with the stored numbers. Throws Error for an unknown key.
MeshImages images_from_json(const JsonInput& input);

/// Keys of a command in logs.
template <class Json>
Json layer_keys_json(const AddLayer& command) {
  return {{"item", layer_json<Json>(command.item, std::identity())}};
}
template <class Json>
Json layer_keys_json(const EditLayer& command) {
  Json json = {{"layer", command.layer}};
  if (command.name) json["name"] = *command.name;
  if (command.transform) json["transform"] = layer_transform_json<Json>(*command.transform, command.transform->file);
  if (command.preprocessing) json["preprocessing"] = preprocessing_json<Json>(*command.preprocessing);
  if (command.colour_map) json["colour_map"] = info_of(*command.colour_map).name;
  if (command.opacity) json["opacity"] = *command.opacity;
  if (command.window) json["window"] = *command.window;
  if (command.level) json["level"] = *command.level;
  if (command.visible) json["visible"] = *command.visible;
  if (command.continues) json["continues"] = true;
  return json;
}
template <class Json>
Json layer_keys_json(const RemoveLayer& command) {
  return {{"layer", command.layer}};
}
template <class Json>
Json layer_keys_json(const FilterVolume& command) {
  return {{"preprocessing", preprocessing_json<Json>(command.preprocessing)}};
}
template <class Json>
Json layer_keys_json(const SetImages& command) {
  return {{"mesh", command.mesh}, {"images", images_json<Json>(command.images, std::identity())}};
}
/// Reads the keys of layer_keys_json(), and accepts those of every log entry. Throws Error for other keys and for
/// values of another type.
void read_layer_keys(const JsonInput& input, AddLayer& command);
void read_layer_keys(const JsonInput& input, EditLayer& command);
void read_layer_keys(const JsonInput& input, RemoveLayer& command);
void read_layer_keys(const JsonInput& input, SetImages& command);
void read_layer_keys(const JsonInput& input, FilterVolume& command);

}  // namespace simplexseg
