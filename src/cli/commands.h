// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <iosfwd>
#include <stdexcept>

namespace CLI {
class App;
}

namespace simplexseg {

/// Where a subcommand writes.
struct Console {
  std::ostream& out;
  std::ostream& err;
  bool shows_progress;  ///< `err` is a terminal
};

/// Asked rightly, and failed all the same: exit status 1. Bad input throws Error: exit status 2.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the command line asks for; set while it is parsed.
using Action = std::function<void(const Console&)>;

// Each adds one subcommand, in a file of its own.
void add_info(CLI::App& app, Action& action);
void add_run(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_phantom(CLI::App& app, Action& action);
void add_plan(CLI::App& app, Action& action);
void add_parameters(CLI::App& app, Action& action);
void add_study(CLI::App& app, Action& action);

}  // namespace simplexseg
