// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <iosfwd>
#include <stdexcept>

#include "cli/command_line.h"

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
void add_archive(const Subcommand& app, Action& action);
void add_info(const Subcommand& app, Action& action);
void add_run(const Subcommand& app, Action& action);
void add_segment(const Subcommand& app, Action& action);
void add_mesh(const Subcommand& app, Action& action);
void add_compare(const Subcommand& app, Action& action);
void add_phantom(const Subcommand& app, Action& action);
void add_plan(const Subcommand& app, Action& action);
void add_parameters(const Subcommand& app, Action& action);
void add_study(const Subcommand& app, Action& action);
void add_clicks(const Subcommand& app, Action& action);

}  // namespace simplexseg
