// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/run_several.h"
#include "core/error.h"

namespace simplexseg {
namespace {

struct Options {
  std::vector<std::string> scenes;
  std::string replay;
  int at_once = 1;
  RunOptions run;
};

void run(const Options& options, const Console& console) {
  const Interrupt interrupt;
  if (options.scenes.size() == 1) {
    const std::string& scene = options.scenes.front();
    return run_file(scene, options.replay, options_for(scene, options.run), console);
  }
  if (!options.replay.empty())
    throw Error("--replay", "a log is of one scene, and several are given", "name the scene that it was written for");
  run_several(options.scenes, options.at_once, options.run, console);
}

}  // namespace

void add_run(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("run", "Runs scenes and writes labels, meshes, a report, a picture");
  const auto options = std::make_shared<Options>();
  sub.add_option("SCENE", options->scenes,
                 "Scene files (docs/scene-format.md). With several, {name} in the name of an output stands for the "
                 "scene's name")
      .required();
  sub.add_option("--labels", options->run.labels, kLabelsHelp);
  const HowFar far = add_run_options(sub, options->run);
  sub.add_option("--at-once", options->at_once, "Of several scenes: how many are run beside each other")
      .within(1, 256)
      .show_default();
  sub.add_option("--replay", options->replay, "Repeat this log of commands on the scene, instead of its steps")
      .excludes(far.steps)
      .excludes(far.until_rest);
  sub.callback([options, &action] { action = [options](const Console& console) { run(*options, console); }; });
}

}  // namespace simplexseg
