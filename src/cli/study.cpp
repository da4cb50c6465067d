// SPDX-License-Identifier: Apache-2.0
#include "cli/study.h"

#include <CLI/CLI.hpp>

namespace simplexseg {

void add_study(CLI::App& app, Action& action) {
  CLI::App* const sub = app.add_subcommand("study", "Measures the program itself, and writes tables and plots");
  sub->require_subcommand(1);
  add_study_stability(*sub, action);
}

}  // namespace simplexseg
