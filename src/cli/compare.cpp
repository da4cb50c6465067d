// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <vector>

#include "cli/commands.h"
#include "cli/load.h"
#include "cli/metric_list.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "core/error.h"
#include "io/files.h"
#include "io/labels_io.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

struct Options {
  std::string reference, test;
  std::optional<double> label;
  double tolerance_mm = kUsualToleranceMm;
  bool json = false, csv = false;
};

void compare_files(const Options& options, const Console& console) {
  if (options.label && !std::isfinite(*options.label)) throw Error("--label", "not a finite number", "give a label");
  MaskComparison comparison;
  std::vector<std::string> warnings;
  {
    const Progress progress(console, "comparing");
    const LoadedVolume reference_file = load_volume(options.reference);
    for (const std::string& warning : reference_file.warnings)
      warnings.push_back(quoted(options.reference) + ": " + warning);
    const Volume& reference = reference_file.volume;
    const Volume test = load_labels_onto(options.test, reference.geometry(), "the reference", warnings);
    comparison = compare_masks(mask_of(reference, options.label), mask_of(test, options.label), options.tolerance_mm);
  }
  print_warnings(warnings, console);
  if (options.json) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const Metric& metric : metric_list()) json[metric.key] = metric.value(comparison);  // infinite ones are null
    for (const Metric& metric : metric_list()) json["definitions"][metric.key] = metric.definition;
    console.out << json.dump(2) << "\n";
    return;
  }
  if (options.csv) {
    console.out << "metric,value,definition\n";
    for (const Metric& metric : metric_list()) {
      char value[40];
      std::snprintf(value, sizeof value, "%.9g", metric.value(comparison));
      console.out << metric.key << "," << value << ",\"" << metric.definition << "\"\n";
    }
    return;
  }
  std::vector<std::vector<std::string>> rows{{"metric", "value", " definition"}};
  for (const Metric& metric : metric_list())
    rows.push_back(
        {metric.title, fixed(metric.value(comparison), metric.decimals), std::string(" ") + metric.definition});
  print_table(console.out, rows, 3);
}

}  // namespace

void add_compare(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("compare", "Agreement of two label volumes: Dice, surface distances, surface Dice, volumes");
  const auto options = std::make_shared<Options>();
  sub.add_option("REFERENCE", options->reference, "Label volume that is the truth").required();
  sub.add_option("TEST", options->test,
                 "Label volume, on another grid resampled onto the reference's, or DICOM RT structure set")
      .required();
  sub.add_option("--label", options->label, "The label to compare; without it every voxel that is not 0");
  sub.add_option("--tolerance", options->tolerance_mm, "Of the surface Dice, in mm").within(0.0, 1e6).show_default();
  const Option json = sub.add_flag("--json", options->json, "Print JSON");
  sub.add_flag("--csv", options->csv, "Print CSV, a line for each metric").excludes(json);
  sub.callback(
      [options, &action] { action = [options](const Console& console) { compare_files(*options, console); }; });
}

}  // namespace simplexseg
