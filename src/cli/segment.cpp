// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <memory>
#include <thread>

#include "app/progress.h"
#include "app/simulate.h"
#include "cli/commands.h"
#include "cli/network_option.h"
#include "cli/plan.h"
#include "cli/run_scene.h"
#include "cli/segment_scene.h"
#include "cli/slicer_description.h"
#include "core/error.h"
#include "core/thread_pool.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

struct SegmentOptions {
  SegmentRequest request;
  RunOptions run;
  NetworkOptions network;
  bool plan = false;
};

void segment(const SegmentOptions& options, const Console& console) {
  const Interrupt interrupt;
  RunInput input;
  input.start = seconds_now();
  {
    const Progress progress(console, "reading");
    const SegmentRequest& request = options.request;
    const std::vector<std::filesystem::path> read_from{request.image, request.scene, request.start_labels,
                                                       request.reference, request.label_preset};
    const auto check = [&](const SceneFile& file) { check_outputs(options.run, file, "", read_from); };
    if (options.plan) {
      if (!options.network.server.empty())
        throw Error("--plan", "the server is called in a run only", "omit --network");
      if (starts_from_models(request))
        throw Error("--plan", "the models find the positions of their organs in a run only",
                    "add --seed X,Y,Z and --radius");
      input.loaded = load_scene(segment_scene(request), "",
                                {.settings = options.run.settings, .voxels = LoadOptions::Voxels::Skip});
    } else {
      OutputChecks checks(read_from);
      check_outputs(options.run, checks);  // before the template and the labels are read
      input.loaded = load_scene(segment_scene(request), "", {.settings = options.run.settings, .check = check});
      if (starts_from_models(request)) {
        const int threads = options.run.threads > 0 ? options.run.threads : options.run.max_threads;
        ThreadPool pool(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
        const std::vector<std::string> warnings =
            place_seeds_by_models(request, input.loaded.scene, input.loaded.volume,
                                  [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); });
        input.loaded.warnings.insert(input.loaded.warnings.end(), warnings.begin(), warnings.end());
      }
    }
  }
  if (options.plan) {
    const int steps = options.run.steps.value_or(options.run.until_rest ? 0 : input.loaded.scene.steps);
    return print_plan(std::move(input.loaded), steps, true, console);
  }
  input.scene = options.request.scene;
  if (!options.network.server.empty())
    input.commands = starts_from_network(options.network, input.loaded.scene, input.loaded.volume, console);
  run_scene(std::move(input), options.run, console);
}

}  // namespace

void add_segment(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "segment", "Segments an image from seeds, labels or a template scene; writes the same outputs as run");
  const auto options = std::make_shared<SegmentOptions>();
  SegmentRequest& request = options->request;
  sub.add_option("IMAGE", request.image, "Volume file, or folder of a DICOM series").required();
  sub.add_option("LABELS,--labels", options->run.labels, kLabelsHelp).not_empty();
  const Option seeds = sub.add_option("--seed", request.seeds,
                                      "Centre of an object, X,Y,Z in mm (LPS: towards left, back and head of the "
                                      "patient); one mesh per seed, or the seed of the next mesh of --scene")
                           .one_value_each();
  sub.add_option("--radius", request.radii, "Radius of the seeds, mm: one for all or one per seed; default: 10")
      .one_value_each();
  sub.add_option("--labels-start", request.start_labels,
                 "Label volume or DICOM RT structure set with the initial meshes: one mesh per label, or for each mesh "
                 "of --scene "
                 "the label with its number")
      .not_empty()
      .excludes(seeds);
  sub.add_option(
         "--scene", request.scene,
         "Template scene: provides parameters, meshes, points and steps; its volume, poses and references are ignored")
      .not_empty();
  sub.add_option("--name", request.names, "Names of the meshes, one per mesh").one_value_each();
  sub.add_option("--label-preset", request.label_preset,
                 "Label preset (simplexseg-cli labels) or file of one: label, colour and DICOM codes by name")
      .not_empty();
  sub.add_option("--model", request.models,
                 "Model of the organ (simplexseg-cli model train): one for all meshes or one per mesh, in their order. "
                 "Without seeds, labels and scene: one mesh per model, where it finds its organ")
      .one_value_each()
      .not_empty();
  sub.add_option("--organ", request.organs,
                 "Organ to segment of a model of several, by its name; default: all that are found")
      .one_value_each()
      .not_empty();
  sub.add_option(
         "--seed-organ", request.seed_organs,
         "Organ of a model of several in which a --seed lies: one per seed, in their order. The model finds the "
         "other organs from these")
      .one_value_each()
      .not_empty();
  for (const auto& [name, points, doc] :
       {std::tuple("--inside", &request.inside, "Point inside the object: X,Y,Z, or MESH=X,Y,Z with several meshes"),
        std::tuple("--outside", &request.outside, "Point outside the object"),
        std::tuple("--boundary", &request.boundary, "Point on the boundary of the object")})
    sub.add_option(name, *points, doc).one_value_each();
  sub.add_option("--reference", request.reference,
                 "Label volume for the comparison in the report: all voxels that are not 0; with several meshes the "
                 "label with the number of the mesh")
      .not_empty();
  sub.add_option("--reference-label", request.reference_label, "Label of the reference for all meshes");
  sub.add_option("--volume", request.volume_number, "Number of the volume in a 4D file or series, counted from 1")
      .within(1, kMaxVolumes);
  sub.add_option("--series", request.series, "UID of a series in a DICOM folder; default: the largest series");
  add_run_options(sub, options->run);
  add_network_options(sub, options->network);
  sub.add_flag("--plan", options->plan, "Print the plan like plan --json, without a run");
  sub.add_print_flag("--xml", slicer_description,
                     "Print the description of this subcommand for 3D Slicer (Slicer Execution Model) and exit");
  sub.callback([options, &action] { action = [options](const Console& console) { segment(*options, console); }; });
}

}  // namespace simplexseg
