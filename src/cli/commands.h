// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "app/console.h"
#include "cli/command_line.h"

namespace simplexseg {

/// Work of the parsed command line; the callbacks of the subcommands set it.
using Action = std::function<void(const Console&)>;

// Each function adds one subcommand and has its own source file.
void add_archive(const Subcommand& app, Action& action);
void add_info(const Subcommand& app, Action& action);
void add_run(const Subcommand& app, Action& action);
void add_segment(const Subcommand& app, Action& action);
void add_mesh(const Subcommand& app, Action& action);
void add_measure(const Subcommand& app, Action& action);
void add_compare(const Subcommand& app, Action& action);
void add_phantom(const Subcommand& app, Action& action);
void add_plan(const Subcommand& app, Action& action);
void add_labels(const Subcommand& app, Action& action);
void add_parameters(const Subcommand& app, Action& action);
void add_study(const Subcommand& app, Action& action);
void add_model(const Subcommand& app, Action& action);
void add_clicks(const Subcommand& app, Action& action);
void add_register(const Subcommand& app, Action& action);
void add_layer(const Subcommand& app, Action& action);
void add_filter(const Subcommand& app, Action& action);
void add_follow(const Subcommand& app, Action& action);
void add_serve(const Subcommand& app, Action& action);

}  // namespace simplexseg
