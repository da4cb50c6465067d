// SPDX-License-Identifier: Apache-2.0
#include "cli/run_scene.h"

#include <algorithm>
#include <ostream>

#include "app/load.h"
#include "app/progress.h"
#include "app/report.h"
#include "app/simulate.h"
#include "app/slice_picture.h"
#include "core/error.h"
#include "core/number_text.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/scene/layer_images.h"
#include "io/scene/references.h"
#include "io/scene/scene_export.h"
#include "io/scene/scene_io.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"
#include "session/session.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

void write_outputs(const RunOptions& options, const Session& session, const LayerImages& layers, RunReport& report,
                   bool low_is_bright, const Console& console) {
  const Scene& scene = session.scene();
  const VolumeGeometry grid =
      options.grid.empty() ? session.volume().geometry() : open_volume(options.grid).info.geometry;
  if (!options.fractions.empty()) {
    make_folder(options.fractions);
    save_fractions(options.fractions, scene, grid);
  }
  if (!options.labels.empty()) {
    const std::string note = save_labels(options.labels, scene, grid, session.volume().geometry());
    if (!note.empty()) console.err << "note: " << note << "\n";
  }
  if (holds_several_surfaces(options.meshes)) {
    save_surfaces(options.meshes, scene);
  } else if (!options.meshes.empty()) {
    make_folder(options.meshes);
    save_meshes(options.meshes, scene, "." + options.mesh_format);
  }
  if (!options.save.empty()) write_scene(options.save, scene, session.history());
  if (!options.picture.empty())
    save_view(options.picture,
              draw_slices(session.volume(), scene, low_is_bright, options.picture_size, LayerPicture(scene, layers)),
              scene);
  if (options.report.empty()) return;
  const std::string note = write_report(options.report, report, scene);
  if (!note.empty()) console.err << "note: " << note << "\n";
}

VolumeSampling sampling_named(const std::string& name) {
  if (name == "linear") return VolumeSampling::Linear;
  if (name == "fetched") return VolumeSampling::Fetched;
  return VolumeSampling::Filtered;
}

}  // namespace

std::vector<fs::path> inputs_of(const SceneFile& file, const fs::path& folder) {
  std::vector<fs::path> inputs{file.volume};
  const auto add = [&](const std::string& path) {
    try {
      inputs.push_back(find_data(path, folder));
    } catch (const Error&) {  // reported when the file is read
    }
  };
  for (const MeshItem& item : file.scene.meshes) {
    if (item.start && !item.start->network) add(item.start->path);
    if (item.reference) add(item.reference->labels);
  }
  return inputs;
}

void check_outputs(const RunOptions& options, OutputChecks& checks) {
  if (options.backend == "cuda" && options.threads > 0)
    throw Error("--threads", "it applies to the CPU, not to --backend cuda", "omit one of the two");
  if (!options.grid.empty()) checks.add_input(options.grid);
  if (!options.labels.empty()) require_labels_name(options.labels);
  if (!options.picture.empty()) require_view_name(options.picture);
  if (!options.save.empty()) require_scene_name(options.save);
  for (const std::string& output : {options.labels, options.report, options.picture, options.save})
    if (!output.empty()) checks.require_file(output);
  const bool one_file = holds_several_surfaces(options.meshes);
  if (!options.meshes.empty()) require_mesh_name(one_file ? options.meshes : "mesh." + options.mesh_format);
  if (one_file) checks.require_file(options.meshes);
  for (const std::string& output : {one_file ? std::string() : options.meshes, options.fractions})
    if (!output.empty()) checks.require_folder(output);
  if (!options.grid.empty() && options.labels.empty() && options.fractions.empty())
    throw Error("--grid", "there is nothing to write on it", "add --labels or --fractions, or omit it");
  if (options.grid.empty()) return;
  open_volume(options.grid);  // throws before the run if it cannot be read
  if (!options.labels.empty() && extension_of(options.labels) == ".dcm")
    throw Error("--grid", "DICOM labels need the grid of their image", "write another format, or omit --grid");
}

void check_outputs(const RunOptions& options, const SceneFile& file, const fs::path& folder,
                   const std::vector<fs::path>& read_from) {
  std::vector<fs::path> inputs = inputs_of(file, folder);
  inputs.insert(inputs.end(), read_from.begin(), read_from.end());
  OutputChecks checks(std::move(inputs));
  check_outputs(options, checks);
  if (file.volume.empty() && options.grid.empty() && !(options.labels.empty() && options.fractions.empty())) {
    throw Error(options.labels.empty() ? "--fractions" : "--labels",
                "the scene has no volume, so the grid of the labels is unknown",
                "add 'volume' to the scene, or use --grid");
  }
  if (!options.labels.empty()) require_labels_name(options.labels, file.scene);
  if (!options.picture.empty()) require_view_name(options.picture, file.scene);
  if (!options.save.empty()) require_scene_name(options.save, file.scene);
  for (const auto& [output, extension] : {std::pair(options.meshes, "." + options.mesh_format),
                                          std::pair(options.fractions, std::string(kFractionsExtension))}) {
    std::error_code failure;
    if (output.empty() || !fs::is_directory(output, failure)) continue;  // a new folder contains no input
    for (const std::string& name : mesh_file_names(file.scene, extension)) checks.require_file(fs::path(output) / name);
  }
}

void run_scene(RunInput input, const RunOptions& options, const Console& console) {
  LoadedInput& loaded = input.loaded;
  const References references = std::move(loaded.references);
  Interrupt::check();

  const int threads = options.threads > 0 ? options.threads : options.max_threads;
  EngineChoice choice =
      engine_for(options.backend, options.backend == "cuda" ? 0 : threads, sampling_named(options.sampling));
  RunReport report;
  report.scene_path = input.scene;
  report.warnings = loaded.warnings;
  report.volume_path = loaded.volume_path.string();
  report.intensity_unit = unit_after(loaded.scene.volume_preprocessing.filters, loaded.intensity_unit);
  report.geometry = loaded.volume.geometry();
  if (!loaded.volume.empty()) report.voxel_type = to_string(loaded.volume.type());
  describe_engine(report, *choice.engine, threads);
  report.note = choice.note;
  Session session(std::move(choice.engine), std::move(choice.make_fallback), options.max_threads);
  session.set_field_solver(std::move(choice.fields));
  session.set_layer_source(layer_file_source(fs::path(input.scene).parent_path()));
  session.open(std::move(loaded.scene), std::move(loaded.volume), std::move(loaded.history));
  add_filters(session, std::move(loaded.volumes));
  for (const Command& command : input.commands) session.apply(command);
  report.load_ms = 1000 * (seconds_now() - input.start);

  const int scene_steps = options.steps.value_or(session.scene_without_poses().steps);
  const bool until_rest = options.until_rest || (!options.steps && scene_steps == 0);
  TracedClock clock(session, options.report.empty() ? nullptr : &references);
  const Advance advanced =
      input.log ? replay(session, *input.log, clock, console)
                : simulate(session, until_rest ? kMaxStepsUntilRest : scene_steps, until_rest, clock, console);
  session.scene();  // copies the poses from the engine, which is part of the time of the simulation
  report.wall_ms = 1000 * clock.stop();
  report.steps = advanced.steps;
  report.at_rest = advanced.at_rest;
  report.failure = advanced.failure;
  report.cuts = advanced.cuts;
  report.bytes_allocated = session.engine().bytes_allocated();
  if (const std::optional<std::string> notice = session.pop_notice()) {
    report.note = *notice;
    describe_engine(report, session.engine(), 0);
  }
  print_warnings(loaded.warnings, console);
  for (const std::string& line : report.cuts) console.err << "note: " << one_line(line, 1000) << "\n";
  // Printed only if CUDA could be available: a program built without CUDA always uses the CPU.
  if (!report.note.empty() && cuda_unavailable_reason() != "built without CUDA")
    console.err << one_line(report.note, 1000) << "\n";

  as_failure([&] {
    {
      const Progress progress(console, "measuring");
      for (const MeshItem& item : session.scene().meshes) {
        report.meshes.push_back(report_of(item, session.scene(), session.volume().geometry(), references.mask_for(item),
                                          clock.trace().of(item.id)));
        Interrupt::check();
      }
      add_measurements(report, session.scene(), session.volume());
    }
    const Progress progress(console, "writing");
    write_outputs(options, session, loaded.layers, report, loaded.low_is_bright, console);
  });
  print_report(console.out, report);
  if (report.failure) throw Failure("after " + counted(report.steps, "step") + ": " + *report.failure);
  if (until_rest && !input.log && !report.at_rest) {
    console.err << "note: not settled after " << counted(report.steps, "step")
                << "; set --steps, or raise simulation.rest_tolerance\n";
  }
}

StepOptions add_run_options(const Subcommand& sub, RunOptions& options) {
  sub.add_option("--backend", options.backend,
                 "Processor: cpu, cuda, or auto: CUDA if a device is available, else the CPU")
      .one_of({"auto", "cpu", "cuda"})
      .show_default();
  sub.add_option(
         "--sampling", options.sampling,
         "Interpolation of the volume on a CUDA device: filtered (texture unit, 8-bit fractions), fetched (texture, "
         "float interpolation) or linear (linear memory)")
      .one_of({"filtered", "fetched", "linear"})
      .show_default();
  sub.add_option("--threads", options.threads, "CPU threads; default: all cores").within(1, 1024);
  const Option steps =
      sub.add_option("--steps", options.steps, "Number of steps; default: that of the scene").within(0, 1000000000);
  const Option rest = sub.add_flag("--until-settled,--until-rest", options.until_rest,
                                   "Run until the meshes settle, at most 100000 steps")
                          .excludes(steps);
  sub.add_option("--set", options.settings,
                 "Set a parameter: simulation.PARAMETER=VALUE, forces.FORCE.PARAMETER=VALUE or "
                 "meshes.NAME.FORCE.PARAMETER=VALUE; see simplexseg-cli parameters")
      .one_value_each();
  sub.add_option("--meshes", options.meshes,
                 "Output folder for the meshes: NAME.ply, or another --mesh-format; or one file (.3mf or .glb) for all")
      .not_empty();
  sub.add_option("--mesh-format", options.mesh_format, "Format of the files of --meshes; ply is lossless")
      .one_of({"ply", "obj", "stl", "vtk", "vtp", "3mf", "glb"})
      .show_default();
  sub.add_option("--fractions", options.fractions,
                 "Output folder for partial-volume labels: NAME.nii.gz with the fraction of each voxel inside the mesh")
      .not_empty();
  sub.add_option("--grid", options.grid,
                 "Volume whose grid --labels and --fractions get; default: the volume of the scene")
      .not_empty();
  sub.add_option("--save", options.save,
                 "Output file (.json) for the scene after the run, to continue it or to open it")
      .not_empty();
  sub.add_option("--report", options.report, "Output file for the report (JSON)").not_empty();
  sub.add_option(
         "--picture", options.picture,
         "Output file for three slices with the outlines of the meshes (.png, .ppm, or .dcm: secondary capture)")
      .not_empty();
  sub.add_option("--picture-size", options.picture_size, "Largest width and height of a slice in the picture, pixels")
      .within(32, 4000)
      .show_default();
  return {steps, rest};
}

}  // namespace simplexseg
