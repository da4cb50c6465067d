// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <ostream>
#include <set>
#include <thread>

#include "cli/commands.h"
#include "cli/load.h"
#include "cli/progress.h"
#include "cli/report.h"
#include "cli/simulate.h"
#include "cli/slice_picture.h"
#include "core/error.h"
#include "io/files.h"
#include "io/mesh_io.h"
#include "io/references.h"
#include "io/volume_io.h"
#include "mesh/mesh_geometry.h"
#include "session/label_map.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

constexpr int kMostStepsUntilRest = 100000;

struct Options {
  std::string scene, backend = "auto", sampling = "filtered";
  int threads = 0;
  std::optional<int> steps;
  bool until_rest = false;
  std::vector<std::string> settings;
  std::string labels, meshes, report, replay, picture;
};

/// Throws Error, before any time is spent, where an output could not be written.
void check_outputs(const Options& options, const fs::path& volume) {
  std::error_code failure;
  for (const std::string& output : {options.labels, options.report, options.picture}) {
    if (output.empty()) continue;
    const AtomicFile writable(output);
    for (const fs::path& input : {volume, fs::path(options.scene), fs::path(options.replay)}) {
      if (!input.empty() && fs::equivalent(output, input, failure)) {
        throw Error("cannot write " + quoted(fs::path(output)), "the run reads this file", "name another");
      }
    }
  }
  if (!options.picture.empty()) require_picture_name(options.picture);
  if (!options.labels.empty()) {
    static const std::set<std::string> known{".nii", ".nii.gz", ".nrrd", ".mha"};
    if (!known.count(extension_of(options.labels))) {
      throw Error("cannot write " + quoted(fs::path(options.labels)), "the extension is none of a label volume's",
                  "name it .nii, .nii.gz, .nrrd or .mha");
    }
  }
  if (!options.meshes.empty()) {
    fs::create_directories(options.meshes, failure);
    if (!fs::is_directory(options.meshes)) {
      throw Error("cannot make the folder " + quoted(fs::path(options.meshes)),
                  failure ? failure.message() : "there is a file of that name", "name another");
    }
  }
}

/// A file name for a mesh: what separates folders is replaced, and a name that is taken gets a number.
std::string file_name_for(const std::string& name, std::set<std::string>& taken) {
  std::string stem = one_line(name, 100);
  for (char& c : stem) {
    if (c == '/' || c == '\\') c = '_';
  }
  if (stem.empty() || stem[0] == '.') stem = "_" + stem;
  std::string unique = stem;
  for (int n = 2; !taken.insert(unique).second; ++n) unique = stem + "-" + std::to_string(n);
  return unique + ".ply";
}

void write_outputs(const Options& options, const Session& session, RunReport& report, const Console& console) {
  const Scene& scene = session.scene();
  if (!options.labels.empty()) {
    const LabelMap map = make_label_map(scene, session.volume().geometry());
    if (map.shared_voxels > 0) {
      console.err << "note: " << map.shared_voxels
                  << " voxels lie inside two or more meshes; the first of them has them\n";
    }
    write_labels(options.labels, map.labels);
  }
  std::set<std::string> taken;
  for (const MeshItem& item : scene.meshes) {
    if (!options.meshes.empty()) write_mesh(fs::path(options.meshes) / file_name_for(item.name, taken), item.mesh);
  }
  if (!options.picture.empty()) write_picture(options.picture, draw_slices(session.volume(), scene));
  if (!options.report.empty()) write_report(options.report, report, scene);
}

void run(const Options& options, const Console& console) {
  const Interrupt interrupt;
  if (options.backend == "cuda" && options.threads > 0) {
    throw Error("--threads", "it is for the CPU, and --backend cuda is given", "leave one of the two out");
  }
  const double start = seconds_now();
  LoadedScene loaded = load_scene(options.scene, options.settings, console);
  if (loaded.volume.empty() && !options.labels.empty()) {
    throw Error("--labels", "the scene names no volume, so there is no grid for labels", "add 'volume' to the scene");
  }
  check_outputs(options, loaded.volume_path);
  const std::optional<LogFile> log = options.replay.empty() ? std::nullopt : std::optional(read_log(options.replay));
  const References references(loaded.scene, fs::path(options.scene).parent_path(), loaded.volume.geometry());
  Interrupt::check();

  const VolumeSampling sampling = options.sampling == "linear"    ? VolumeSampling::Linear
                                  : options.sampling == "fetched" ? VolumeSampling::Fetched
                                                                  : VolumeSampling::Filtered;
  EngineChoice choice = engine_for(options.backend, options.threads, sampling);
  RunReport report;
  report.scene_path = options.scene;
  report.volume_path = loaded.volume_path.string();
  report.geometry = loaded.volume.geometry();
  if (!loaded.volume.empty()) report.voxel_type = to_string(loaded.volume.type());
  report.backend = choice.engine->backend();
  report.device = choice.engine->description();
  report.note = choice.note;
  if (report.backend == "cpu")
    report.threads =
        options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  Session session(std::move(choice.engine), std::move(choice.spare));
  session.open(std::move(loaded.scene), std::move(loaded.volume));
  report.load_ms = 1000 * (seconds_now() - start);

  const int scene_steps = options.steps.value_or(session.scene_without_poses().steps);
  const bool until_rest = options.until_rest || (!options.steps && scene_steps == 0);
  TracedClock clock(session, options.report.empty() ? nullptr : &references);
  const Advance advanced =
      log ? replay(session, *log, clock, console)
          : simulate(session, until_rest ? kMostStepsUntilRest : scene_steps, until_rest, clock, console);
  session.scene();  // the poses are back from the engine: part of the simulation's time
  report.wall_ms = 1000 * clock.stop();
  report.steps = advanced.steps;
  report.at_rest = advanced.at_rest;
  report.failure = advanced.failure;
  report.cuts = advanced.cuts;
  report.bytes_held = session.engine().bytes_held();
  if (const std::optional<std::string> notice = session.take_notice()) {
    report.note = *notice;
    report.backend = session.engine().backend(), report.device = session.engine().description();
  }
  print_warnings(loaded.warnings, console);
  for (const std::string& line : report.cuts) console.err << "note: " << one_line(line, 1000) << "\n";
  // Worth a line only where CUDA could have been had: a program built without it always takes the CPU.
  if (!report.note.empty() && why_no_cuda() != "built without CUDA") console.err << one_line(report.note, 1000) << "\n";

  as_failure([&] {
    {
      const Progress progress(console, "measuring");
      for (const MeshItem& item : session.scene().meshes) {
        const MeshTrace* trace = clock.trace().of(item.id);
        report.meshes.push_back({item.name, item.mesh.vertex_count(), measure(item.mesh), references.compare_with(item),
                                 trace ? trace->samples : std::vector<TraceSample>{}});
        Interrupt::check();
      }
    }
    const Progress progress(console, "writing");
    write_outputs(options, session, report, console);
  });
  print_report(console.out, report);
  if (report.failure) throw Failure("after " + std::to_string(report.steps) + " steps: " + *report.failure);
  if (until_rest && !log && !report.at_rest) {
    console.err << "note: not at rest after " << report.steps
                << " steps; give --steps, or raise simulation.rest_tolerance\n";
  }
}

}  // namespace

void add_run(CLI::App& app, Action& action) {
  CLI::App* const sub = app.add_subcommand("run", "Runs a scene and writes labels, meshes, a report, a picture");
  const auto options = std::make_shared<Options>();
  sub->add_option("SCENE", options->scene, "Scene file (docs/scene-format.md)")->required();
  sub->add_option("--backend", options->backend, "auto takes CUDA where a device can be used, else the CPU")
      ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
      ->capture_default_str();
  sub->add_option(
         "--sampling", options->sampling,
         "How a CUDA device reads the volume: filtered (by its texture unit, fractions of 8 bits), fetched (from a "
         "texture, interpolated in float) or linear (from linear memory)")
      ->check(CLI::IsMember({"filtered", "fetched", "linear"}))
      ->capture_default_str();
  sub->add_option("--threads", options->threads, "CPU threads; without it as many as the machine has")
      ->check(CLI::Range(1, 1024));
  CLI::Option* const steps = sub->add_option("--steps", options->steps, "Steps to do; without it those of the scene")
                                 ->check(CLI::Range(0, 1000000000));
  CLI::Option* const rest =
      sub->add_flag("--until-rest", options->until_rest, "Go on until nothing moves, 100000 steps at most")
          ->excludes(steps);
  sub->add_option("--set", options->settings,
                  "Change a parameter first: simulation.PARAMETER=VALUE, forces.FORCE.PARAMETER=VALUE or "
                  "meshes.NAME.FORCE.PARAMETER=VALUE; see simplexseg-cli parameters")
      ->allow_extra_args(false);
  sub->add_option("--labels", options->labels, "Write the voxels inside the meshes here (.nii, .nii.gz, .nrrd, .mha)");
  sub->add_option("--meshes", options->meshes, "Write each mesh as NAME.ply into this folder");
  sub->add_option("--report", options->report, "Write a report here (JSON)");
  sub->add_option("--replay", options->replay, "Repeat this log of commands on the scene, instead of its steps")
      ->excludes(steps)
      ->excludes(rest);
  sub->add_option("--picture", options->picture, "Write three slices with the meshes' outlines here (.png, .ppm)");
  sub->callback([options, &action] { action = [options](const Console& console) { run(*options, console); }; });
}

}  // namespace simplexseg
