// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>
#include <ostream>

#include "app/load.h"
#include "app/progress.h"
#include "cli/commands.h"
#include "cli/label_option.h"
#include "core/number_text.h"
#include "image/label_surface.h"
#include "io/labels/label_mesh.h"
#include "io/labels/labels_io.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

struct MeshOptions {
  std::string input;
  std::vector<std::string> outputs;
  std::string label;
  int part = 0, vertices = 0;
  std::optional<double> threshold;
};

void check_outputs(const MeshOptions& options) {
  OutputChecks checks({options.input});
  for (const std::string& output : options.outputs) {
    require_mesh_name(output);
    checks.require_file(output);
  }
}

std::string sizes_of(const std::vector<std::size_t>& parts) {
  constexpr std::size_t kMaxListed = 8;
  std::string text;
  for (std::size_t n = 0; n < parts.size() && n < kMaxListed; ++n) text += (n ? ", " : "") + std::to_string(parts[n]);
  return text + (parts.size() > kMaxListed ? ", ..." : "");
}

SimplexMesh mesh_of_labels(const MeshOptions& options, const Console& console) {
  const fs::path path = options.input;
  const Progress progress(console, "creating the mesh");
  LabelChoice choice = label_choice(options.label);
  choice.part = options.part, choice.threshold = options.threshold;
  const LoadedLabels loaded = load_labels(path, choice);
  print_warnings(loaded.warnings, console);
  choice.label = label_of(choice, loaded.segments, path);
  const ChosenLabel chosen = choose_label(loaded.volume, choice, quoted(path));
  const bool is_single = chosen.parts == std::vector<std::size_t>{1};
  console.out << "parts     " << chosen.parts.size() << " (" << sizes_of(chosen.parts)
              << (is_single ? " voxel)" : " voxels)");
  if (choice.part > 0) console.out << "; part " << choice.part << " is used";
  console.out << "\n";
  return mesh_of_mask(chosen.mask, options.vertices);
}

void make_mesh(const MeshOptions& options, const Console& console) {
  check_outputs(options);
  const bool chooses_labels =
      !options.label.empty() || options.part > 0 || options.vertices > 0 || options.threshold.has_value();
  if (is_mesh_name(options.input) && chooses_labels)
    throw Error("mesh " + quoted(options.input),
                "--label, --part, --threshold and --vertices apply to label volumes only", "omit these options");
  const SimplexMesh mesh = is_mesh_name(options.input) ? read_mesh(options.input) : mesh_of_labels(options, console);
  for (const std::string& output : options.outputs) write_mesh(output, mesh);
  const Topology topology = topology_of(mesh);
  const SurfaceMeasures measures = measure(mesh);
  console.out << "vertices  " << mesh.vertex_count() << "\nsurfaces  " << topology.surfaces << ", genus "
              << topology.genus << "\nvolume    " << volume_text(measures.volume_mm3) << "\nedges     "
              << length_text(measures.mean_edge_mm) << " on average\n";
}

}  // namespace

void add_mesh(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "mesh", "Creates a closed mesh from a label volume, from DICOM contours or from a closed surface");
  const auto options = std::make_shared<MeshOptions>();
  sub.add_option(
         "IN", options->input,
         "Label volume, DICOM RT structure set, or closed surface (.ply, .obj, .stl, .vtk, .vtp), which is converted "
         "to a simplex mesh")
      .required();
  sub.add_option("OUT", options->outputs, "Output files: .ply, .obj, .stl, .vtk, .vtp, .3mf or .glb")
      .required()
      .not_empty();
  sub.add_option("--label", options->label,
                 "Value of the label, or its name if the file contains names; default: all voxels that are not 0");
  sub.add_option("--threshold", options->threshold, kThresholdHelp);
  sub.add_option("--part", options->part,
                 "Number of the connected part, 1 for the largest; default: all parts in one mesh")
      .within(1, 1000000000);
  sub.add_option("--vertices", options->vertices,
                 "Approximate number of vertices; default: triangle edges of 1.25 voxels")
      .within(4, 50000000);
  sub.callback([options, &action] { action = [options](const Console& console) { make_mesh(*options, console); }; });
}

}  // namespace simplexseg
