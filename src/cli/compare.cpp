// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <vector>

#include "cli/commands.h"
#include "cli/load.h"
#include "cli/progress.h"
#include "cli/table.h"
#include "core/error.h"
#include "image/metrics.h"
#include "io/labels_io.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

struct Options {
  std::string reference, test;
  std::optional<double> label;
  bool json = false;
};

void compare_files(const Options& options, const Console& console) {
  if (options.label && !std::isfinite(*options.label)) throw Error("--label", "not a finite number", "give a label");
  Agreement agreement;
  std::vector<std::string> warnings;
  {
    const Progress progress(console, "comparing");
    const Volume reference = read_volume(options.reference);
    const Volume test =
        onto_grid(read_volume(options.test), reference.geometry(), options.test, "the reference", warnings);
    agreement = compare(mask_of(reference, options.label), mask_of(test, options.label));
  }
  print_warnings(warnings, console);
  if (options.json) {  // an infinite distance (one mask is empty) is null: JSON has no infinity
    console.out << nlohmann::ordered_json{{"dice", agreement.dice},
                                          {"hd_mm", agreement.hd_mm},
                                          {"hd95_mm", agreement.hd95_mm},
                                          {"assd_mm", agreement.assd_mm},
                                          {"hd_directed_mm", agreement.hd_directed_mm},
                                          {"hd95_directed_mm", agreement.hd95_directed_mm},
                                          {"asd_directed_mm", agreement.asd_directed_mm},
                                          {"reference_mm3", agreement.reference_mm3},
                                          {"test_mm3", agreement.test_mm3}}
                       .dump(2)
                << "\n";
    return;
  }
  print_table(
      console.out,
      {{"Dice", "HD mm", "HD95 mm", "ASSD mm", "reference ml", "test ml"},
       {fixed(agreement.dice, 4), fixed(agreement.hd_mm, 3), fixed(agreement.hd95_mm, 3), fixed(agreement.assd_mm, 3),
        fixed(agreement.reference_mm3 / 1000, 3), fixed(agreement.test_mm3 / 1000, 3)}},
      0);
}

}  // namespace

void add_compare(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("compare", "Agreement of two label volumes: Dice, surface distances, volumes");
  const auto options = std::make_shared<Options>();
  sub.add_option("REFERENCE", options->reference, "Label volume that is the truth").required();
  sub.add_option("TEST", options->test, "Label volume; on another grid it is resampled onto the reference's")
      .required();
  sub.add_option("--label", options->label, "The label to compare; without it every voxel that is not 0");
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback(
      [options, &action] { action = [options](const Console& console) { compare_files(*options, console); }; });
}

}  // namespace simplexseg
