// SPDX-License-Identifier: Apache-2.0
#include "io/registration/filters.h"

#include <array>
#include <memory>
#include <optional>
#include <ostream>

#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "cli/commands.h"
#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/output_checks.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

constexpr std::size_t kFilterCount = 5;
constexpr std::size_t kMostParameters = 3;

struct FilterOptions {
  std::string input, output;
  std::array<bool, kFilterCount> chosen{};
  /// Parameters of each filter in the order of its list.
  std::array<std::array<std::optional<double>, kMostParameters>, kFilterCount> values{};
  int threads = 0;
};

/// Name of the option of a parameter: --n4-shrink.
std::string option_name(const FilterInfo& info, const FilterParameter& parameter) {
  return std::string("--") + info.name + "-" + parameter.name;
}

/// Filter that the options name, with its parameters.
std::pair<FilterKind, std::vector<double>> choice_of(const FilterOptions& options) {
  std::optional<FilterKind> kind;
  for (std::size_t n = 0; n < kFilterCount; ++n) {
    if (!options.chosen[n]) continue;
    if (kind) throw Error("cannot filter the image", "several filters are named", "name one of them");
    kind = static_cast<FilterKind>(n);
  }
  if (!kind)
    throw Error("cannot filter the image", "no filter is named",
                "add --n4, --diffusion, --median, --isotropic or --suv");
  std::vector<double> values = default_parameters(*kind);
  for (std::size_t f = 0; f < kFilterCount; ++f) {
    const FilterInfo& info = info_of(static_cast<FilterKind>(f));
    for (std::size_t p = 0; p < info.parameters.size(); ++p) {
      const std::optional<double>& value = options.values[f][p];
      if (!value) continue;
      if (info.kind != *kind)
        throw Error("cannot use " + option_name(info, info.parameters[p]), "it belongs to another filter",
                    std::string("add --") + info.name + " or omit it");
      values[p] = *value;
    }
  }
  return {*kind, values};
}

void filter_file(const FilterOptions& options, const Console& console) {
  OutputChecks checks({options.input});
  require_volume_name(options.output);
  checks.require_file(options.output);
  auto [kind, values] = choice_of(options);
  std::vector<std::string> warnings;
  {
    const Interrupt interrupt;
    Progress progress(console, "filtering");
    LoadedVolume loaded = load_volume(options.input);
    warnings = std::move(loaded.warnings);
    if (kind == FilterKind::Uptake && values[0] == 0) {
      if (!loaded.uptake.refusal.empty())
        throw Error("uptake values of " + quoted(options.input), loaded.uptake.refusal, "name --suv-factor");
      values[0] = loaded.uptake.factor;
    }
    const Volume result = filter_volume(loaded.volume, kind, values, options.threads, [&](double done) {
      Interrupt::check();
      progress.set(done);
    });
    const std::string warning = as_failure([&] { return write_volume(options.output, result); });
    if (!warning.empty()) warnings.push_back(warning);
  }
  print_warnings(warnings, console);
}

}  // namespace

void add_filter(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("filter", "Filters an image and writes the result");
  const auto options = std::make_shared<FilterOptions>();
  sub.add_option("IN", options->input, "Image or DICOM folder").required();
  sub.add_option("OUT", options->output, "Output: image (.nii.gz, .nii, .nrrd, .mha)").required();
  for (std::size_t f = 0; f < kFilterCount; ++f) {
    const FilterInfo& info = info_of(static_cast<FilterKind>(f));
    sub.add_flag(std::string("--") + info.name, options->chosen[f], info.help);
    for (std::size_t p = 0; p < info.parameters.size(); ++p) {
      const FilterParameter& parameter = info.parameters[p];
      sub.add_option(option_name(info, parameter), options->values[f][p],
                     std::string(parameter.help) + "; default " + general_text(parameter.value, 6))
          .within(parameter.min, parameter.max);
    }
  }
  sub.add_option("--threads", options->threads, "Threads; 0 for all cores. The result does not depend on them")
      .within(0, 1024)
      .show_default();
  sub.callback([options, &action] { action = [options](const Console& console) { filter_file(*options, console); }; });
}

}  // namespace simplexseg
