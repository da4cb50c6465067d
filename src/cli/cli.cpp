// SPDX-License-Identifier: Apache-2.0
#include "cli/cli.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <new>
#include <vector>

#include "cli/commands.h"
#include "cli/slicer_description.h"
#include "core/error.h"
#include "io/files.h"
#include "io/parameter_text.h"

namespace simplexseg {
namespace {

constexpr int kFailed = 1, kBadInput = 2;

int complain(std::ostream& err, const std::string& message, int status) {
  err << "simplexseg-cli: " << one_line(message, 2000) << std::endl;
  return status;
}

int act(const Action& action, std::ostream& out, std::ostream& err) {
  try {
    action({out, err, &err == &std::cerr && isatty(STDERR_FILENO) == 1});
    out.flush();
    return out ? 0
               : complain(err, "the output cannot be written: disk full or pipe closed; check where it goes", kFailed);
  } catch (const Error& error) {
    return complain(err, error.what(), kBadInput);
  } catch (const Failure& failure) {
    return complain(err, failure.what(), kFailed);
  } catch (const std::bad_alloc&) {
    return complain(err, "out of memory: the scene does not fit; use fewer vertices or a smaller volume", kFailed);
  } catch (const std::exception& error) {
    return complain(err, std::string("internal error: ") + error.what() + "; please report it", kFailed);
  }
}

/// 3D Slicer calls a module by the program's name alone: options without a subcommand are those of `segment`.
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
  add_compare(program, action);
  add_phantom(program, action);
  add_plan(program, action);
  add_parameters(program, action);
  add_study(program, action);
  add_clicks(program, action);
  add_archive(program, action);
  program.add_answer("--xml", slicer_description,
                     "Print what 3D Slicer is to know of segment (Slicer Execution Model)");
  const std::vector<const char*> arguments = with_subcommand(app, argc, argv);
  try {
    app.parse(static_cast<int>(arguments.size()), arguments.data());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, err);
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      std::vector<std::string> names;
      for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
      return complain(err, "the subcommand " + unknown_name(argv[1], names) + "; see simplexseg-cli --help", kBadInput);
    }
    std::string called = "simplexseg-cli";
    for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
      at = at->get_subcommands().front();
      called += " " + at->get_name();
    }
    return complain(err, std::string(error.what()) + "; see " + called + " --help", kBadInput);
  }
  return act(action, out, err);
}

}  // namespace simplexseg
