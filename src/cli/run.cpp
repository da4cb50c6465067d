// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "cli/commands.h"
#include "cli/load.h"
#include "cli/progress.h"
#include "cli/run_scene.h"
#include "cli/simulate.h"

namespace simplexseg {
namespace {

struct Options {
  std::string scene, replay;
  RunOptions run;
};

void run(const Options& options, const Console& console) {
  const Interrupt interrupt;
  RunInput input;
  input.start = seconds_now();
  // A log may take back what was done before it began; what is saved goes on with the same history.
  const bool needs_history = !options.replay.empty() || !options.run.save.empty();
  input.loaded = load_with_progress(options.scene, options.run.settings, console,
                                    needs_history ? LoadOptions::History::Read : LoadOptions::History::LeaveOut);
  input.scene = options.scene;
  input.read_from = {options.scene, options.replay};
  if (!options.replay.empty()) input.log = read_log(options.replay);
  run_scene(std::move(input), options.run, console);
}

}  // namespace

void add_run(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("run", "Runs a scene and writes labels, meshes, a report, a picture");
  const auto options = std::make_shared<Options>();
  sub.add_option("SCENE", options->scene, "Scene file (docs/scene-format.md)").required();
  sub.add_option("--labels", options->run.labels, kLabelsHelp);
  const HowFar far = add_run_options(sub, options->run);
  sub.add_option("--replay", options->replay, "Repeat this log of commands on the scene, instead of its steps")
      .excludes(far.steps)
      .excludes(far.until_rest);
  sub.callback([options, &action] { action = [options](const Console& console) { run(*options, console); }; });
}

}  // namespace simplexseg
