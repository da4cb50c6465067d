// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "app/progress.h"
#include "cli/commands.h"
#include "cli/run_several.h"
#include "core/error.h"

namespace simplexseg {
namespace {

struct RunCommandOptions {
  std::vector<std::string> scenes;
  std::string replay;
  int at_once = 1;
  RunOptions run;
};

void run(const RunCommandOptions& options, const Console& console) {
  const Interrupt interrupt;
  if (options.scenes.size() == 1) {
    const std::string& scene = options.scenes.front();
    return run_file(scene, options.replay, options_for(scene, options.run), console);
  }
  if (!options.replay.empty())
    throw Error("--replay", "a log belongs to one scene, not to several", "name the scene of the log only");
  run_several(options.scenes, options.at_once, options.run, console);
}

}  // namespace

void add_run(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("run", "Runs scenes and writes labels, meshes, a report and a picture");
  const auto options = std::make_shared<RunCommandOptions>();
  sub.add_option("SCENE", options->scenes,
                 "Scene files (docs/scene-format.md). With several scenes, {name} in an output name is replaced by the "
                 "name of the scene")
      .required();
  sub.add_option("--labels", options->run.labels, kLabelsHelp).not_empty();
  const StepOptions steps = add_run_options(sub, options->run);
  sub.add_option("--at-once", options->at_once, "Number of scenes that run in parallel").within(1, 256).show_default();
  sub.add_option("--replay", options->replay, "Log of commands to replay on the scene, instead of its steps")
      .not_empty()
      .excludes(steps.steps)
      .excludes(steps.until_rest);
  sub.callback([options, &action] { action = [options](const Console& console) { run(*options, console); }; });
}

}  // namespace simplexseg
