// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>

#include "cli/commands.h"
#include "cli/plan.h"
#include "cli/progress.h"
#include "cli/run_scene.h"
#include "cli/segment_scene.h"
#include "cli/simulate.h"
#include "cli/slicer_description.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

struct Options {
  SegmentRequest request;
  RunOptions run;
  bool plan = false;
};

void segment(const Options& options, const Console& console) {
  const Interrupt interrupt;
  RunInput input;
  input.start = seconds_now();
  {
    const Progress progress(console, "reading");
    const auto voxels = options.plan ? LoadOptions::Voxels::LeaveOut : LoadOptions::Voxels::Read;
    input.loaded = load_scene(segment_scene(options.request), "", {.settings = options.run.settings, .voxels = voxels});
  }
  if (options.plan) {
    const int steps = options.run.steps.value_or(options.run.until_rest ? 0 : input.loaded.scene.steps);
    return print_plan(std::move(input.loaded), steps, true, console);
  }
  input.scene = options.request.scene;
  input.read_from = {options.request.scene, options.request.start_labels, options.request.reference};
  run_scene(std::move(input), options.run, console);
}

}  // namespace

void add_segment(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "segment", "Segments an image from seeds, labels or a template scene, and writes what run writes");
  const auto options = std::make_shared<Options>();
  SegmentRequest& request = options->request;
  sub.add_option("IMAGE", request.image, "Volume file, or folder of a DICOM series").required();
  sub.add_option("LABELS,--labels", options->run.labels, kLabelsHelp);
  const Option seeds = sub.add_option("--seed", request.seeds,
                                      "Middle of an object, X,Y,Z in mm (LPS: to the patient's left, back and head); "
                                      "each makes a mesh, or is the seed of the next mesh of --scene")
                           .one_value_each();
  sub.add_option("--radius", request.radii, "Of the seeds in mm: one for all, or one for each; without it 10")
      .one_value_each();
  sub.add_option(
         "--labels-start", request.start_labels,
         "Label volume or RT structure set from which meshes start: one for each label, or each mesh of --scene "
         "from the label of its number")
      .excludes(seeds);
  sub.add_option(
      "--scene", request.scene,
      "Template: its parameters, meshes, points and steps are taken for the image; not its volume, poses and "
      "references");
  sub.add_option("--name", request.names, "Of the meshes, one each").one_value_each();
  for (const auto& [name, points, doc] :
       {std::tuple("--inside", &request.inside, "Place inside of the object, X,Y,Z, or MESH=X,Y,Z of several meshes"),
        std::tuple("--outside", &request.outside, "Place outside of it"),
        std::tuple("--boundary", &request.boundary, "Place that its surface is to pass")})
    sub.add_option(name, *points, doc).one_value_each();
  sub.add_option("--reference", request.reference,
                 "Labels that the report compares with: every voxel that is not 0; of several meshes the label of "
                 "each one's number");
  sub.add_option("--reference-label", request.reference_label, "This label of them, for every mesh");
  sub.add_option("--volume", request.volume_number, "Which volume of a 4D file or series, from 1")
      .within(1, kMostVolumes);
  sub.add_option("--series", request.series, "UID of the series of a DICOM folder; without it the largest");
  add_run_options(sub, options->run);
  sub.add_flag("--plan", options->plan, "Run nothing: print what plan --json prints of a scene");
  sub.add_answer("--xml", slicer_description, "Print what 3D Slicer is to know of this (Slicer Execution Model)");
  sub.callback([options, &action] { action = [options](const Console& console) { segment(*options, console); }; });
}

}  // namespace simplexseg
