// SPDX-License-Identifier: Apache-2.0
#include "io/mesh_io.h"

#include <algorithm>
#include <string>

#include "io/atomic_file.h"
#include "io/files.h"
#include "io/mesh_formats.h"
#include "io/ply.h"
#include "io/surface_formats.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

struct Format {
  const char* extension;
  std::string (*bytes_of)(const SimplexMesh&);
  PolygonSurface (*surface_of)(const std::string& bytes, const Refuse& refuse);  ///< nullptr: mesh_of_ply()
};
constexpr Format kFormats[] = {{".ply", ply_of, nullptr},
                               {".obj", obj_of, surface_of_obj},
                               {".stl", stl_of, surface_of_stl},
                               {".vtk", vtk_of, surface_of_vtk},
                               {".vtp", vtp_of, surface_of_vtp}};

/// nullptr where the extension is that of none.
const Format* format_of(const fs::path& path) {
  const std::string extension = extension_of(path);
  const auto format =
      std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& f) { return extension == f.extension; });
  return format == std::end(kFormats) ? nullptr : format;
}

}  // namespace

bool is_mesh_name(const fs::path& path) { return format_of(path) != nullptr; }

void require_mesh_name(const fs::path& path) {
  if (is_mesh_name(path)) return;
  throw Error("cannot write the mesh " + quoted(path),
              "'" + one_line(extension_of(path)) + "' is not a known extension",
              "use .ply (which keeps every bit), .obj, .stl, .vtk or .vtp");
}

void write_mesh(const fs::path& path, const SimplexMesh& mesh) {
  require_mesh_name(path);
  if (mesh.positions.empty() || mesh.positions.size() != mesh.neighbours.size()) {
    throw Error("cannot write the mesh " + quoted(path),
                "it is empty or has not one triple of neighbours for each vertex", "make a mesh first");
  }
  AtomicFile file(path);
  write_bytes(file, format_of(path)->bytes_of(mesh));
  file.commit();
}

SimplexMesh read_mesh(const fs::path& path) {
  require_file(path);
  const Format* const format = format_of(path);
  if (!format) {
    throw Error("cannot read the mesh " + quoted(path),
                "'" + one_line(extension_of(path)) + "' is not an extension of a mesh",
                "give .ply, .obj, .stl, .vtk or .vtp");
  }
  const Refuse refuse = [&](const std::string& why) {
    throw Error("cannot read " + quoted(path), why, "export it again as a closed surface, as .stl, .obj or .ply");
  };
  const std::string bytes = read_bytes(path);
  SimplexMesh mesh = format->surface_of ? simplex_mesh_of(format->surface_of(bytes, refuse), refuse)
                                        : mesh_of_ply(bytes, quoted(path));
  try {
    validate(mesh);
  } catch (const Error& invalid) {
    throw Error("cannot read " + quoted(path), std::string("its mesh is not valid: ") + invalid.what(),
                "save it again from the program that made it");
  }
  return mesh;
}

}  // namespace simplexseg
