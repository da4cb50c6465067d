// SPDX-License-Identifier: Apache-2.0
#include "cli/run_several.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <new>
#include <ostream>
#include <sstream>
#include <thread>

#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "core/error.h"
#include "gpu/backend.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

std::string name_of(const std::string& scene) {
  std::string name = fs::path(scene).filename().string();
  for (const std::string ending : {".json", ".simplexseg"})
    if (name.size() > ending.size() && name.ends_with(ending)) name.resize(name.size() - ending.size());
  return name;
}

std::string with_name(std::string text, const std::string& name) {
  const std::string mark = kScenePlaceholder;
  for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += name.size())
    text.replace(at, mark.size(), name);
  return text;
}

/// Returns the name and value of each output option.
std::vector<std::pair<const char*, std::string*>> outputs_of(RunOptions& options) {
  return {{"--labels", &options.labels}, {"--meshes", &options.meshes},   {"--fractions", &options.fractions},
          {"--report", &options.report}, {"--picture", &options.picture}, {"--save", &options.save}};
}

/// Throws Error if several scenes would write the same file.
void check_names(const std::vector<std::string>& scenes, RunOptions options) {
  bool writes = false;
  for (const auto& [option, output] : outputs_of(options)) {
    writes = writes || !output->empty();
    if (!output->empty() && output->find(kScenePlaceholder) == std::string::npos)
      throw Error(option, "all " + std::to_string(scenes.size()) + " scenes would write " + quoted(fs::path(*output)),
                  std::string("put ") + kScenePlaceholder + " in it as a placeholder for the name of the scene");
  }
  std::map<std::string, std::string> scene_of_name;
  for (const std::string& scene : scenes) {
    const auto [other, inserted] = scene_of_name.emplace(name_of(scene), scene);
    if (!inserted && writes)
      throw Error(quoted(fs::path(scene)), "its outputs would replace those of " + quoted(fs::path(other->second)),
                  "rename one of the two scenes");
  }
}

/// Result of one scene: its texts on stdout and stderr, and whether it succeeded.
struct SceneOutcome {
  std::string out, err;
  bool succeeded = false;
};

SceneOutcome run_one(const std::string& scene, const RunOptions& options) {
  SceneOutcome outcome;
  std::ostringstream out, err;
  try {
    const DeviceStream stream;
    run_file(scene, "", options_for(scene, options), {out, err, false});
    outcome.succeeded = true;
  } catch (const std::bad_alloc&) {
    err << "out of memory; lower --at-once\n";
  } catch (const std::exception& error) {
    err << one_line(error.what(), 2000) << "\n";
  }
  outcome.out = out.str(), outcome.err = err.str();
  return outcome;
}

bool is_interrupted() {
  try {
    Interrupt::check();
    return false;
  } catch (const Failure&) {
    return true;
  }
}

}  // namespace

RunOptions options_for(const std::string& scene, const RunOptions& options) {
  RunOptions own = options;
  for (const auto& [option, output] : outputs_of(own)) *output = with_name(*output, name_of(scene));
  return own;
}

void run_file(const std::string& scene, const std::string& replay, const RunOptions& options, const Console& console) {
  RunInput input;
  input.start = seconds_now();
  // A log may undo actions from before its start, and a saved scene keeps the undo history.
  const bool needs_history = !replay.empty() || !options.save.empty();
  input.scene = scene;
  const std::vector<fs::path> read_from{scene, replay};
  OutputChecks checks(read_from);
  check_outputs(options, checks);  // before the files of the scene are read
  if (!replay.empty()) input.log = read_log(replay);
  input.loaded = load_with_progress(
      scene,
      {.settings = options.settings,
       .history = needs_history ? LoadOptions::History::Read : LoadOptions::History::Skip,
       .layers = options.picture.empty() ? LoadOptions::Layers::Skip : LoadOptions::Layers::Read,
       .check = [&](const SceneFile& file) { check_outputs(options, file, fs::path(scene).parent_path(), read_from); }},
      console);
  run_scene(std::move(input), options, console);
}

void run_several(const std::vector<std::string>& scenes, int at_once, const RunOptions& options,
                 const Console& console) {
  check_names(scenes, options);
  for (const std::string& scene : scenes) require_file(scene);
  OutputChecks checks(std::vector<fs::path>(scenes.begin(), scenes.end()));
  for (const std::string& scene : scenes) check_outputs(options_for(scene, options), checks);
  const std::size_t workers = std::min<std::size_t>(std::max(at_once, 1), scenes.size());
  RunOptions shared = options;
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  shared.max_threads = static_cast<int>(std::max<std::size_t>(1, cores / workers));

  std::atomic<std::size_t> next = 0, done = 0, failed = 0;
  std::mutex output;  // messages of one scene are written together
  const auto work = [&] {
    for (std::size_t n = next++; n < scenes.size() && !is_interrupted(); n = next++) {
      const SceneOutcome outcome = run_one(scenes[n], shared);
      if (is_interrupted()) return;
      ++(outcome.succeeded ? done : failed);
      const std::lock_guard lock(output);
      console.out << "[" << done + failed << "/" << scenes.size() << "] " << scenes[n] << "\n"
                  << outcome.out << std::flush;
      std::istringstream lines(outcome.err);
      for (std::string line; std::getline(lines, line);) console.err << name_of(scenes[n]) << ": " << line << "\n";
      console.err << std::flush;
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t n = 1; n < workers; ++n) threads.emplace_back(work);
  work();
  threads.clear();
  Interrupt::check();
  console.out << done << " done, " << failed << " failed\n";
  if (failed > 0)
    throw Failure(std::to_string(failed) + " of " + std::to_string(scenes.size()) +
                  " scenes failed; see the messages above");
}

}  // namespace simplexseg
