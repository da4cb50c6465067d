// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>

#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "cli/commands.h"
#include "cli/run_scene.h"
#include "core/error.h"
#include "gpu/backend.h"
#include "io/platform/files.h"
#include "io/scene/layer_file.h"
#include "io/scene/scene_export.h"
#include "io/scene/scene_io.h"
#include "session/session.h"

namespace simplexseg {
namespace {

struct LayerOptions {
  std::string scene, image, output;
  std::string transform, name, colours;
  std::optional<double> opacity, window, level;
};

/// Layer for the image, with the options.
LayerFile layer_of(const LayerOptions& options) {
  LayerFile layer = read_layer(options.image);
  LayerItem& item = layer.item;
  if (!options.name.empty()) item.name = options.name;
  if (!options.colours.empty()) item.colour_map = find_colour_map(options.colours).value_or(item.colour_map);
  if (options.opacity) item.opacity = static_cast<float>(*options.opacity);
  item.window = options.window.value_or(item.window);
  item.level = options.level.value_or(item.level);
  Transform loaded;
  if (!options.transform.empty()) item.transform = load_layer_transform(options.transform, loaded);
  return layer;
}

void add_layer_to_scene(const LayerOptions& options, const Console& console) {
  const std::filesystem::path folder = std::filesystem::path(options.scene).parent_path();
  const auto check = [&](const SceneFile& file) {
    OutputChecks checks(inputs_of(file, folder));
    for (const std::string& input : {options.scene, options.image, options.transform}) checks.add_input(input);
    require_scene_name(options.output, file.scene);
    checks.require_file(options.output);
    if (file.volume.empty())
      throw Error(quoted(options.scene), "it has no volume over which a layer could be shown", "add 'volume' to it");
  };
  std::vector<std::string> warnings;
  {
    const Interrupt interrupt;
    const Progress progress(console, "reading");
    LoadedInput loaded = load_scene(options.scene, {.history = LoadOptions::History::Read, .check = check});
    LayerFile layer = layer_of(options);
    warnings = std::move(loaded.warnings);
    warnings.insert(warnings.end(), layer.warnings.begin(), layer.warnings.end());
    Session session(make_cpu_engine());
    session.open(std::move(loaded.scene), std::move(loaded.volume), std::move(loaded.history));
    session.apply(AddLayer{std::move(layer.item)});
    as_failure([&] { write_scene(options.output, session.scene(), session.history()); });
  }
  print_warnings(warnings, console);
}

}  // namespace

void add_layer(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("layer", "Adds an image to a scene as a layer over its volume");
  const auto options = std::make_shared<LayerOptions>();
  sub.add_option("SCENE", options->scene, "Scene file (docs/scene-format.md)").required();
  sub.add_option("IMAGE", options->image, "Image or DICOM folder").required();
  sub.add_option("OUT", options->output, "Output: scene with the layer (.json)").required();
  sub.add_option(
         "--transform", options->transform,
         "Transform from points of the volume to points of IMAGE: .tfm, .txt, .mat, .h5, or a displacement field")
      .not_empty();
  sub.add_option("--name", options->name, "Name; default: that of the series or the file").not_empty();
  sub.add_option("--colours", options->colours, "Colour map; default: grey, for uptake values of PET hot")
      .one_of({"grey", "inverted_grey", "hot", "green", "magenta"});
  sub.add_option("--opacity", options->opacity, "Opacity of a blend, default 0.5").within(0.0, 1.0);
  sub.add_option("--window", options->window, "Difference of the values with the first and the last colour");
  sub.add_option("--level", options->level, "Value with the colour in the middle");
  sub.callback(
      [options, &action] { action = [options](const Console& console) { add_layer_to_scene(*options, console); }; });
}

}  // namespace simplexseg
