// SPDX-License-Identifier: Apache-2.0
#include "io/scene/layer_text.h"

#include <limits>

#include "core/error.h"
#include "io/scene/json_input.h"
#include "io/scene/parameter_text.h"
#include "io/scene/scene_text.h"
#include "io/source/volume_info.h"

namespace simplexseg {
namespace {

ColourMap read_colour_map(const JsonInput& input) {
  const std::string name = input.text();
  if (const std::optional<ColourMap> map = find_colour_map(name)) return *map;
  std::vector<std::string> names;
  for (const ColourMapInfo& info : colour_maps()) names.emplace_back(info.name);
  input.fail("the colour map " + unknown_name(name, names), "correct it");
}

LayerTransform read_transform_keys(const JsonInput& input, const std::filesystem::path& folder) {
  input.expect_keys({"file", "checksum", "affine"});
  LayerTransform transform;
  if (input.has("file")) {
    transform.file = absolute_if_found(input["file"].text(), folder);
    if (input.has("checksum")) transform.checksum = input["checksum"].text();
  }
  if (!input.has("affine")) return transform;
  const JsonInput affine = input["affine"];
  if (affine.size() != 12) affine.fail("it does not have 12 numbers", "give the three rows of a 3x4 matrix");
  for (int n = 0; n < 12; ++n) transform.affine(n / 4, n % 4) = affine[n].number();
  return transform;
}

ItemId read_layer_id(const JsonInput& input) {
  return static_cast<ItemId>(input.integer_between(0, std::numeric_limits<int>::max()));
}

}  // namespace

LayerItem layer_from_json(const JsonInput& input, const std::filesystem::path& folder) {
  input.expect_keys({"name", "image", "volume_number", "series", "checksum", "scale", "unit", "preprocessing",
                     "transform", "colour_map", "opacity", "window", "level", "visible"});
  LayerItem layer;
  layer.name = input["name"].text();
  layer.path = absolute_if_found(input["image"].text(), folder);
  if (input.has("volume_number")) layer.number = input["volume_number"].integer_between(1, kMaxVolumes);
  if (input.has("series")) layer.series = input["series"].text();
  if (input.has("checksum")) layer.checksum = input["checksum"].text();
  if (input.has("scale")) layer.scale = input["scale"].number();
  if (input.has("unit")) layer.unit = input["unit"].text();
  if (input.has("preprocessing")) layer.preprocessing = preprocessing_from_json(input["preprocessing"]);
  if (input.has("transform")) layer.transform = read_transform_keys(input["transform"], folder);
  if (input.has("colour_map")) layer.colour_map = read_colour_map(input["colour_map"]);
  if (input.has("opacity")) layer.opacity = static_cast<float>(input["opacity"].number());
  layer.window = input["window"].number();
  layer.level = input["level"].number();
  if (input.has("visible")) layer.visible = input["visible"].boolean();
  try {
    check_layer(layer);
  } catch (const Error& error) {
    input.fail(error.what(), "correct the layer");
  }
  return layer;
}

MeshImages images_from_json(const JsonInput& input) {
  input.expect_keys({"main", "further"});
  MeshImages images;
  images.main = read_layer_id(input["main"]);
  for (int n = 0; input.has("further") && n < input["further"].size(); ++n)
    images.further.push_back(read_layer_id(input["further"][n]));
  return images;
}

void read_layer_keys(const JsonInput& input, AddLayer& command) {
  input.expect_keys({"item", "after_steps", "command"});
  command.item = layer_from_json(input["item"], {});
}

void read_layer_keys(const JsonInput& input, EditLayer& command) {
  input.expect_keys({"layer", "name", "transform", "preprocessing", "colour_map", "opacity", "window", "level",
                     "visible", "continues", "after_steps", "command"});
  command.layer = read_layer_id(input["layer"]);
  if (input.has("name")) command.name = input["name"].text_or_empty();
  if (input.has("transform")) command.transform = read_transform_keys(input["transform"], {});
  if (input.has("preprocessing")) command.preprocessing = preprocessing_from_json(input["preprocessing"]);
  if (input.has("colour_map")) command.colour_map = read_colour_map(input["colour_map"]);
  if (input.has("opacity")) command.opacity = static_cast<float>(input["opacity"].number());
  if (input.has("window")) command.window = input["window"].number();
  if (input.has("level")) command.level = input["level"].number();
  if (input.has("visible")) command.visible = input["visible"].boolean();
  command.continues = input.has("continues") && input["continues"].boolean();
}

void read_layer_keys(const JsonInput& input, FilterVolume& command) {
  input.expect_keys({"preprocessing", "after_steps", "command"});
  command.preprocessing = preprocessing_from_json(input["preprocessing"]);
}

void read_layer_keys(const JsonInput& input, RemoveLayer& command) {
  input.expect_keys({"layer", "after_steps", "command"});
  command.layer = read_layer_id(input["layer"]);
}

void read_layer_keys(const JsonInput& input, SetImages& command) {
  input.expect_keys({"mesh", "images", "after_steps", "command"});
  command.mesh = read_layer_id(input["mesh"]);
  command.images = images_from_json(input["images"]);
}

}  // namespace simplexseg
