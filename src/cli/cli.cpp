// SPDX-License-Identifier: Apache-2.0
#include "cli/cli.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <new>
#include <vector>

#include "cli/commands.h"
#include "cli/slicer_description.h"
#include "core/c_locale.h"
#include "core/error.h"
#include "io/platform/files.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {
namespace {

constexpr int kFailed = 1, kBadInput = 2;

int report_failure(std::ostream& err, const std::string& message, int status) {
  err << "simplexseg-cli: " << one_line(message, 2000) << std::endl;
  return status;
}

int run_action(const Action& action, std::ostream& out, std::ostream& err) {
  try {
    action({out, err, &err == &std::cerr && isatty(STDERR_FILENO) == 1});
    out.flush();
    if (out) return 0;
    return report_failure(err, "cannot write the output: disk full or pipe closed; check the output file or pipe",
                          kFailed);
  } catch (const Error& error) {
    return report_failure(err, error.what(), kBadInput);
  } catch (const Failure& failure) {
    return report_failure(err, failure.what(), kFailed);
  } catch (const std::bad_alloc&) {
    return report_failure(err, "out of memory: the scene is too large; use fewer vertices or a smaller volume",
                          kFailed);
  } catch (const std::exception& error) {
    return report_failure(err, std::string("internal error: ") + error.what() + "; please report it", kFailed);
  }
}

/// Returns the arguments with the subcommand `segment` inserted if the first argument is one of its options: 3D Slicer
/// calls a module without a subcommand.
std::vector<const char*> with_subcommand(const CLI::App& app, int argc, const char* const* argv) {
  std::vector<const char*> arguments(argv, argv + argc);
  const char* const segment = "segment";
  if (argc > 1 && argv[1][0] == '-' && !app.get_option_no_throw(argv[1]) &&
      app.get_subcommand(segment)->get_option_no_throw(argv[1]))
    arguments.insert(arguments.begin() + 1, segment);
  return arguments;
}

}  // namespace

int run_cli(int argc, const char* const* argv, std::ostream& out, std::ostream& err) {
  CLI::App app("Segments medical volumes with deformable 2-simplex meshes, without a window.", "simplexseg-cli");
  app.set_version_flag("--version", "simplexseg-cli " SIMPLEXSEG_VERSION);
  app.require_subcommand(1);
  app.failure_message([](const CLI::App*, const CLI::Error& error) { return std::string(error.what()); });
  Action action;
  const Subcommand program(app);
  add_info(program, action);
  add_run(program, action);
  add_segment(program, action);
  add_mesh(program, action);
  add_measure(program, action);
  add_compare(program, action);
  add_phantom(program, action);
  add_plan(program, action);
  add_labels(program, action);
  add_parameters(program, action);
  add_study(program, action);
  add_model(program, action);
  add_clicks(program, action);
  add_register(program, action);
  add_filter(program, action);
  add_follow(program, action);
  add_layer(program, action);
  add_archive(program, action);
  add_serve(program, action);
  program.add_print_flag("--xml", slicer_description,
                         "Print the description of segment for 3D Slicer (Slicer Execution Model) and exit");
  const std::vector<const char*> arguments = with_subcommand(app, argc, argv);
  try {
    const CLocale c_locale;  // CLI11 parses numbers with strtold
    app.parse(static_cast<int>(arguments.size()), arguments.data());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err);
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      std::vector<std::string> names;
      for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
      return report_failure(err, "the subcommand " + unknown_name(argv[1], names) + "; see simplexseg-cli --help",
                            kBadInput);
    }
    std::string command = "simplexseg-cli";
    for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
      at = at->get_subcommands().front();
      command += " " + at->get_name();
    }
    return report_failure(err, std::string(error.what()) + "; see " + command + " --help", kBadInput);
  }
  return run_action(action, out, err);
}

}  // namespace simplexseg
