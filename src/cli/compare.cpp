// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <vector>

#include "app/load.h"
#include "app/metric_list.h"
#include "app/progress.h"
#include "app/table.h"
#include "cli/commands.h"
#include "cli/label_option.h"
#include "core/number_text.h"
#include "io/labels/label_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAllLabels = "all";

struct CompareOptions {
  std::string reference, test;
  std::string label;            ///< number or name; empty: all labels
  std::string reference_label;  ///< number or name, or kAllLabels; empty: that of `label`
  std::optional<double> threshold;
  double tolerance_mm = kDefaultToleranceMm;
  bool json = false, csv = false;
};

/// Labels of one of the two files. `label`: number or name; `grid`: grid of the other file, null for the reference.
Mask mask_of_file(const fs::path& path, const std::string& label, std::optional<double> threshold,
                  const VolumeGeometry* grid, std::vector<std::string>& warnings) {
  const LabelFile file(path);
  LabelChoice choice = label_choice(label);
  choice.label = label_of(choice, file.segments(), path);
  choice.name.clear();
  choice.threshold = threshold;
  Volume labels;
  if (grid) {
    labels = file.read_onto(*grid, "the reference", warnings, choice);
  } else {
    LoadedLabels loaded = file.read(choice);
    std::move(loaded.warnings.begin(), loaded.warnings.end(), std::back_inserter(warnings));
    labels = std::move(loaded.volume);
  }
  Mask mask = mask_of(labels, choice.label);
  if (std::find(mask.voxels.begin(), mask.voxels.end(), 1) == mask.voxels.end())
    warnings.push_back(quoted(path) + ": no voxel has " +
                       (choice.label ? "the label " + exact_text(*choice.label) : std::string("a label")));
  return mask;
}

void compare_files(const CompareOptions& options, const Console& console) {
  MaskComparison comparison;
  std::vector<std::string> warnings;
  {
    const Progress progress(console, "comparing");
    std::string reference_label = options.reference_label.empty() ? options.label : options.reference_label;
    if (options.reference_label == kAllLabels) reference_label.clear();
    const Mask reference = mask_of_file(options.reference, reference_label, options.threshold, nullptr, warnings);
    const Mask test = mask_of_file(options.test, options.label, options.threshold, &reference.geometry, warnings);
    comparison = compare_masks(reference, test, options.tolerance_mm);
  }
  print_warnings(warnings, console);
  if (options.json) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const Metric& metric : metric_list()) json[metric.key] = metric.value(comparison);  // infinity becomes null
    for (const Metric& metric : metric_list()) json["definitions"][metric.key] = metric.definition;
    console.out << json.dump(2) << "\n";
    return;
  }
  if (options.csv) {
    console.out << "metric,value,definition\n";
    for (const Metric& metric : metric_list()) {
      console.out << metric.key << "," << general_text(metric.value(comparison), 9) << ",\"" << metric.definition
                  << "\"\n";
    }
    return;
  }
  std::vector<std::vector<std::string>> rows{{"metric", "value", " definition"}};
  for (const Metric& metric : metric_list())
    rows.push_back(
        {metric.title, readable(metric.value(comparison), metric.decimals), std::string(" ") + metric.definition});
  print_table(console.out, rows, 3);
}

}  // namespace

void add_compare(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("compare", "Compares two label volumes: Dice, surface distances, surface Dice, volumes");
  const auto options = std::make_shared<CompareOptions>();
  sub.add_option("REFERENCE", options->reference, "Label volume with the truth, or DICOM RT structure set").required();
  sub.add_option("TEST", options->test,
                 "Label volume (resampled if its grid differs from that of REFERENCE) or DICOM RT structure set")
      .required();
  sub.add_option("--label", options->label,
                 "Value of the label to compare, or its name if the file contains names; default: all voxels that are "
                 "not 0");
  sub.add_option("--reference-label", options->reference_label,
                 "Label in REFERENCE, if it differs from --label; all: all voxels that are not 0");
  sub.add_option("--threshold", options->threshold, kThresholdHelp);
  sub.add_option("--tolerance", options->tolerance_mm, "Tolerance of the surface Dice, mm")
      .within(0.0, 1e6)
      .show_default();
  const Option json = sub.add_flag("--json", options->json, "Print JSON");
  sub.add_flag("--csv", options->csv, "Print CSV, one line per metric").excludes(json);
  sub.callback(
      [options, &action] { action = [options](const Console& console) { compare_files(*options, console); }; });
}

}  // namespace simplexseg
