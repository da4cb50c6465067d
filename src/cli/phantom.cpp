// SPDX-License-Identifier: Apache-2.0
#include "study/phantom.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <ostream>

#include "app/load.h"
#include "cli/commands.h"
#include "core/error.h"
#include "core/number_text.h"
#include "image/mask.h"
#include "io/labels/labels_io.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "io/scene/parameter_text.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

constexpr const char* kLabelImage = "label-image";

struct PhantomOptions {
  std::string kind;
  std::vector<std::string> paths;
  std::string labels, type;
  std::optional<double> label;
  PhantomSettings settings;
};

VoxelType type_of(const std::string& name) {
  std::vector<std::string> names;
  for (int t = 0; t <= static_cast<int>(VoxelType::Float64); ++t) {
    names.emplace_back(to_string(static_cast<VoxelType>(t)));
    if (names.back() == name) return static_cast<VoxelType>(t);
  }
  throw Error("--type", "the voxel type " + unknown_name(name, names),
              "use int8 to int32, uint8 to uint32, float32 or float64");
}

void phantom(PhantomOptions options, const Console& console) {
  if (!options.type.empty()) options.settings.type = type_of(options.type);
  const bool from_labels = options.kind == kLabelImage;
  if (options.paths.size() != (from_labels ? 2u : 1u)) {
    throw Error("phantom " + options.kind, counted(options.paths.size(), "path is", "paths are") + " named",
                from_labels ? "name LABELS and OUT" : "name OUT only");
  }
  if (!from_labels && options.label)
    throw Error("--label", "it applies to label-image only", "omit --label, or choose label-image");
  const auto note = [&](const std::string& warning) {
    if (!warning.empty()) print_warnings({warning}, console);
  };
  OutputChecks checks({from_labels ? options.paths[0] : ""});
  for (const std::string& output : {options.paths.back(), options.labels}) {
    if (output.empty()) continue;
    require_volume_name(output);
    checks.require_file(output);
  }
  if (from_labels) {
    const LoadedLabels loaded = load_labels(options.paths[0], {.label = options.label});
    print_warnings(loaded.warnings, console);
    const Volume& labels = loaded.volume;
    const Volume image = image_of_label(labels, options.label, options.settings);
    if (!options.labels.empty()) {
      const Mask mask = mask_of(labels, options.label);
      Volume truth(mask.geometry, VoxelType::UInt8);
      std::copy(mask.voxels.begin(), mask.voxels.end(), truth.voxels<std::uint8_t>().begin());
      note(write_labels(options.labels, truth));
    }
    note(write_volume(options.paths[1], image));
  } else {
    const Phantom made = make_phantom(options.kind, options.settings);
    if (!options.labels.empty()) note(write_labels(options.labels, made.labels));
    note(write_volume(options.paths[0], made.image));
  }
  console.out << "wrote " << options.paths.back() << (options.labels.empty() ? "" : " and " + options.labels) << "\n";
}

}  // namespace

void add_phantom(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("phantom", "Writes a synthetic volume and its reference labels");
  const auto options = std::make_shared<PhantomOptions>();
  std::string kinds;
  for (const PhantomKind& kind : phantom_kinds()) kinds += std::string("\n  ") + kind.name + ": " + kind.doc;
  kinds += std::string("\n  ") + kLabelImage + ": image of a label of a label volume; arguments LABELS OUT";
  PhantomSettings& settings = options->settings;
  sub.add_option("KIND", options->kind, "Kind of phantom:" + kinds).required();
  sub.add_option("PATH", options->paths, "OUT, or LABELS OUT for label-image").required().expected(1, 2).not_empty();
  sub.add_option("--labels", options->labels, "Output file for the truth, a label volume").not_empty();
  sub.add_option("--label", options->label,
                 "Value of the label (label-image only); default: all voxels that are not 0");
  sub.add_option("--size", settings.size, "Voxels along each axis (not for label-image)").show_default();
  sub.add_option("--spacing", settings.spacing_mm, "Spacing of the voxels, mm (not for label-image)").show_default();
  sub.add_option("--contrast", settings.contrast, "Intensity of the object minus that of the background")
      .show_default();
  sub.add_option("--background", settings.background, "Intensity of the background").show_default();
  sub.add_option("--noise", settings.noise_sigma, "Standard deviation of the Gaussian noise").show_default();
  sub.add_option("--seed", settings.seed, "Seed of the random noise").show_default();
  sub.add_option("--type", options->type,
                 "Voxel type: int8 to int32, uint8 to uint32, float32 or float64; default: int16");
  sub.callback([options, &action] { action = [options](const Console& console) { phantom(*options, console); }; });
}

}  // namespace simplexseg
