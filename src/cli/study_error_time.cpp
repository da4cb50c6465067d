// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <ostream>
#include <set>

#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "app/table.h"
#include "cli/study.h"
#include "core/number_text.h"
#include "image/mask.h"
#include "io/picture/plot_io.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "io/scene/set_by_path.h"
#include "study/error_time_report.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 1000, kHeight = 600;
constexpr const char *kFull = "phantom:full", *kHalf = "phantom:half", *kMembrane = "analytic:membrane",
                     *kHalfMembrane = "analytic:membrane-half";

struct StudyErrorTimeOptions {
  std::vector<std::string> scenes, settings;
  std::string folder, backend = "auto";
  int threads = 0, vertices = 20480;
  double budget_s = 3;
};

/// Scene named on the command line. All files are read before the first measurement.
struct NamedScene {
  std::string name;
  std::optional<StudyScene> scene;  ///< none for a membrane, which is not a scene
  bool half = false;                ///< the membrane is fixed on one half only
};

NamedScene read_named_scene(const std::string& word, const StudyErrorTimeOptions& options, const Console& console) {
  if (word == kFull || word == kHalf) {
    StudyScene study = make_phantom_scene(word == kHalf, options.vertices);
    for (const std::string& setting : options.settings) set_by_path(study.scene, setting);
    std::string name = study.name;
    return {std::move(name), std::move(study)};
  }
  if (word == kMembrane || word == kHalfMembrane) {
    const bool half = word == kHalfMembrane;
    return {std::string(half ? "analytic-membrane-half-" : "analytic-membrane-") +
                std::to_string(20 << (2 * sphere_level_for(options.vertices))),
            std::nullopt, half};
  }
  if (word.rfind("phantom:", 0) == 0 || word.rfind("analytic:", 0) == 0)
    throw Error(
        "scene " + quoted(word), "no built-in scene has this name",
        std::string("use ") + kFull + ", " + kHalf + ", " + kMembrane + ", " + kHalfMembrane + " or a scene file");
  LoadedInput loaded = load_with_progress(word, {.settings = options.settings}, console);
  StudyScene study;
  study.name = fs::path(word).stem().string();
  for (const MeshItem& item : loaded.scene.meshes) {
    std::optional<Mask> truth = loaded.references.mask_for(item);
    study.truths.push_back(truth ? std::make_shared<Mask>(std::move(*truth)) : nullptr);
  }
  if (loaded.scene.meshes.empty()) throw Error("scene " + quoted(word), "it has no mesh", "add a mesh to 'meshes'");
  study.scene = std::move(loaded.scene), study.volume = std::move(loaded.volume);
  print_warnings(loaded.warnings, console);
  std::string name = study.name;
  return {std::move(name), std::move(study)};
}

void write_result(const fs::path& folder, const ErrorTimeResult& result) {
  const auto write_both = [&](const std::string& what, const Plot& plot) {
    for (const char* extension : {".svg", ".png"})
      write_plot(folder / (result.name + "-" + what + extension), plot, kWidth, kHeight);
  };
  write_text(folder / (result.name + "-frozen.csv"), frozen_csv(result));
  write_both("work-precision", frozen_plot(result, false, false));
  write_both("convergence", frozen_plot(result, true, false));
  write_both("work-precision-normal", frozen_plot(result, false, true));
  if (result.live.empty()) return;
  write_text(folder / (result.name + "-live.csv"), live_csv(result));
  write_both("surface-error", live_plot(result));
  write_both("refresh", refresh_plot(result));
}

ErrorTimeResult measure_scene(const NamedScene& named, const StudyErrorTimeOptions& options,
                              const EngineFactory& make_engine, const Console& console) {
  const Poll poll = [] { Interrupt::check(); };
  ErrorTimeResult result;
  result.name = named.name;
  {
    const std::unique_ptr<Engine> engine = make_engine();
    result.backend = engine->backend(), result.device = engine->description();
  }
  FrozenProblem problem;
  {
    const Progress progress(console, named.name + ": fixed point");
    problem = named.scene ? frozen_problem_of(named.scene->scene, named.scene->volume, named.scene->frozen_from_start,
                                              make_engine, poll)
                          : make_membrane(named.half, options.vertices);
  }
  result.vertices = problem.vertex_count(), result.how = problem.how, result.start_mm = problem.start_mm;
  {
    Progress progress(console, named.name + ": frozen targets");
    const std::vector<Method> methods = methods_for(problem);
    const double binding_s = binding_seconds(problem, make_engine);
    for (const Method& method : methods) {
      result.frozen.push_back(run_frozen(problem, method, options.budget_s, binding_s, make_engine, poll));
      progress.set(static_cast<double>(result.frozen.size()) / static_cast<double>(methods.size()));
    }
  }
  if (!named.scene) return result;
  for (const MeshItem& item : named.scene->scene.meshes) result.mesh_names.push_back(item.name);
  const LiveStudy live(*named.scene);
  if (!live.has_truth()) return result;
  Progress progress(console, named.name + ": whole runs");
  const std::vector<LiveVariant> variants = live_variants();
  for (const LiveVariant& variant : variants) {
    result.live.push_back(live.run(variant, options.budget_s, make_engine, poll));
    progress.set(static_cast<double>(result.live.size()) / static_cast<double>(variants.size()));
  }
  return result;
}

/// Prints the steps and times at which each method reaches 1% error.
void print_result(std::ostream& out, const ErrorTimeResult& result) {
  out << result.name << ", " << counted(result.vertices, "vertex", "vertices") << ", " << result.device
      << "; fixed point " << result.how << "\n";
  std::vector<std::vector<std::string>> rows{{"method", "steps to 1%", "ms", "along normals: steps", "ms"}};
  for (const FrozenCurve& curve : result.frozen) {
    rows.push_back({curve.method.name});
    for (const bool normal_part : {false, true}) {
      const std::optional<Reached> at = reached(curve.samples, 0.01, normal_part);
      rows.back().push_back(at ? std::to_string(at->steps) : "-");
      rows.back().push_back(at ? fixed_or_dash(1000 * at->seconds, 2) : "-");
    }
  }
  print_table(out, rows, 1);
  out << std::flush;
}

void run_error_time_study(const StudyErrorTimeOptions& options, const Console& console) {
  const Interrupt interrupt;
  if (options.backend == "cuda" && options.threads > 0)
    throw Error("--threads", "it applies to the CPU, not to --backend cuda", "omit one of the two");
  require_writable_folder(options.folder);
  std::vector<NamedScene> scenes;
  std::set<std::string> names;
  for (const std::string& word : options.scenes) {
    scenes.push_back(read_named_scene(word, options, console));
    if (!names.insert(scenes.back().name).second)
      throw Error("scene " + quoted(word), "another scene has the same name, so their output files would collide",
                  "measure it in a separate call");
    Interrupt::check();
  }
  make_folder(options.folder);
  const EngineChoice choice = engine_for(options.backend, options.threads);
  const EngineFactory make_engine = [backend = std::string(choice.engine->backend()), threads = options.threads] {
    return backend == "cpu" ? make_cpu_engine(threads) : make_cuda_engine();
  };
  if (!choice.note.empty() && cuda_unavailable_reason() != "built without CUDA")
    console.err << one_line(choice.note, 1000) << "\n";
  as_failure([&] {
    std::string text =
        "# Error against run time\n\nGenerated by `simplexseg-cli study error-time`; explained in docs/manual.md.\n\n";
    for (const NamedScene& named : scenes) {
      const ErrorTimeResult result = measure_scene(named, options, make_engine, console);
      write_result(options.folder, result);
      text += markdown(result);
      write_text(fs::path(options.folder) / "error-time.md", text);
      print_result(console.out, result);
    }
  });
  console.out << "wrote " << options.folder << "\n";
}

}  // namespace

void add_study_error_time(const Subcommand& studies, Action& action) {
  const Subcommand sub = studies.add_subcommand(
      "error-time", "Measures the error of every solver against run time and steps; writes tables and plots");
  const auto options = std::make_shared<StudyErrorTimeOptions>();
  sub.add_option("SCENE", options->scenes,
                 std::string("Scene files, or ") + kFull + ", " + kHalf +
                     " (sphere that is deformed to an ellipsoid, with image data everywhere or on one half), " +
                     kMembrane + ", " + kHalfMembrane +
                     " (membrane of springs with known equilibrium, fixed everywhere or on one half)")
      .required();
  sub.add_option("--out", options->folder, "Output folder for tables and plots").required().not_empty();
  sub.add_option("--backend", options->backend,
                 "Processor: cpu, cuda, or auto: CUDA if a device is available, else the CPU")
      .one_of({"auto", "cpu", "cuda"})
      .show_default();
  sub.add_option("--threads", options->threads, "CPU threads; default: all cores").within(1, 1024);
  sub.add_option("--budget", options->budget_s, "Largest time of a method, s").within(0.001, 3600.0).show_default();
  sub.add_option("--vertices", options->vertices,
                 "Vertices of the built-in scenes, rounded up to the next sphere resolution")
      .within(20, 1310720)
      .show_default();
  sub.add_option("--set", options->settings, "Set a parameter of all scenes: PATH=VALUE, see run").one_value_each();
  sub.callback(
      [options, &action] { action = [options](const Console& console) { run_error_time_study(*options, console); }; });
}

}  // namespace simplexseg
