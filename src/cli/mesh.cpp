// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>
#include <ostream>

#include "cli/commands.h"
#include "cli/load.h"
#include "cli/progress.h"
#include "image/label_surface.h"
#include "io/atomic_file.h"
#include "io/files.h"
#include "io/header_text.h"
#include "io/label_mesh.h"
#include "io/labels_io.h"
#include "io/mesh_io.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string input;
  std::vector<std::string> outputs;
  std::string label;
  int part = 0, vertices = 0;
};

void check_outputs(const Options& options) {
  std::error_code failure;
  for (const std::string& output : options.outputs) {
    require_mesh_name(output);
    const AtomicFile writable(output);
    if (fs::equivalent(output, options.input, failure))
      throw Error("cannot write " + quoted(fs::path(output)), "the mesh is made of this file", "name another");
  }
}

std::string sizes_of(const std::vector<std::size_t>& parts) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t n = 0; n < parts.size() && n < most; ++n) text += (n ? ", " : "") + std::to_string(parts[n]);
  return text + (parts.size() > most ? ", ..." : "");
}

/// What is no number is a name.
LabelChoice choice_of(const Options& options) {
  LabelChoice choice{std::nullopt, options.part, {}};
  choice.label = number_of<double>(options.label);
  if (!choice.label) choice.name = options.label;
  return choice;
}

SimplexMesh mesh_of_labels(const Options& options, const Console& console) {
  const fs::path path = options.input;
  const Progress progress(console, "making the mesh");
  LabelChoice choice = choice_of(options);
  const LoadedLabels loaded = load_labels(path, choice);
  print_warnings(loaded.warnings, console);
  choice.label = label_of(choice, loaded.segments, path);
  const ChosenLabel chosen = choose_label(loaded.volume, choice, quoted(path));
  console.out << "parts     " << chosen.parts.size() << ", of " << sizes_of(chosen.parts) << " voxels";
  if (choice.part > 0) console.out << "; number " << choice.part << " is taken";
  console.out << "\n";
  return mesh_of_mask(chosen.mask, options.vertices);
}

void make_mesh(const Options& options, const Console& console) {
  check_outputs(options);
  if (is_mesh_name(options.input) && (!options.label.empty() || options.part > 0 || options.vertices > 0))
    throw Error("mesh " + quoted(options.input), "--label, --part and --vertices are for labels, and this is a mesh",
                "leave them out");
  const SimplexMesh mesh = is_mesh_name(options.input) ? read_mesh(options.input) : mesh_of_labels(options, console);
  for (const std::string& output : options.outputs) write_mesh(output, mesh);
  const Topology topology = topology_of(mesh);
  const SurfaceMeasures measures = measure(mesh);
  console.out << "vertices  " << mesh.vertex_count() << "\nsurfaces  " << topology.surfaces << ", genus "
              << topology.genus << "\nvolume    " << measures.volume_mm3 / 1000 << " ml\nedges     "
              << measures.mean_edge_mm << " mm on average\n";
}

}  // namespace

void add_mesh(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("mesh", "Makes a closed mesh of a label of a label volume, or of another program's surface");
  const auto options = std::make_shared<Options>();
  sub.add_option(
         "IN", options->input,
         "Label volume or DICOM contours (RT structure set); or a closed surface (.ply, .obj, .stl, .vtk, .vtp), "
         "which becomes a simplex mesh")
      .required();
  sub.add_option("OUT", options->outputs, "Where to write the mesh: .ply, .obj, .stl, .vtk or .vtp").required();
  sub.add_option(
      "--label", options->label,
      "This label alone, by its number, or its name where the file gives names; without it every voxel that is "
      "not 0");
  sub.add_option("--part", options->part,
                 "Only this connected part of it, 1 is the largest; without it all of them in one mesh")
      .within(1, 1000000000);
  sub.add_option("--vertices", options->vertices,
                 "About so many; without it as many as give triangles of one and a quarter voxels' length")
      .within(4, 50000000);
  sub.callback([options, &action] { action = [options](const Console& console) { make_mesh(*options, console); }; });
}

}  // namespace simplexseg
