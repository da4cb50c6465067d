// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
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
#include "core/error.h"
#include "io/labels/labels_io.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

struct CompareOptions {
  std::string reference, test;
  std::optional<double> label;
  double tolerance_mm = kDefaultToleranceMm;
  bool json = false, csv = false;
};

void compare_files(const CompareOptions& options, const Console& console) {
  if (options.label && !std::isfinite(*options.label))
    throw Error("--label", "it is not a finite number", "use the value of a label");
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
    for (const Metric& metric : metric_list()) json[metric.key] = metric.value(comparison);  // infinity becomes null
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
      app.add_subcommand("compare", "Compares two label volumes: Dice, surface distances, surface Dice, volumes");
  const auto options = std::make_shared<CompareOptions>();
  sub.add_option("REFERENCE", options->reference, "Label volume with the truth").required();
  sub.add_option("TEST", options->test,
                 "Label volume (resampled if its grid differs from that of REFERENCE) or DICOM RT structure set")
      .required();
  sub.add_option("--label", options->label, "Value of the label to compare; default: all voxels that are not 0");
  sub.add_option("--tolerance", options->tolerance_mm, "Tolerance of the surface Dice, mm")
      .within(0.0, 1e6)
      .show_default();
  const Option json = sub.add_flag("--json", options->json, "Print JSON");
  sub.add_flag("--csv", options->csv, "Print CSV, one line per metric").excludes(json);
  sub.callback(
      [options, &action] { action = [options](const Console& console) { compare_files(*options, console); }; });
}

}  // namespace simplexseg
