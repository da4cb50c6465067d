// SPDX-License-Identifier: Apache-2.0
#include "io/mesh_io.h"

#include <algorithm>
#include <string>

#include "io/atomic_file.h"
#include "io/files.h"
#include "io/mesh_formats.h"
#include "io/ply.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

struct Format {
  const char* extension;
  std::string (*bytes_of)(const SimplexMesh&);
};
constexpr Format kFormats[] = {
    {".ply", ply_of}, {".obj", obj_of}, {".stl", stl_of}, {".vtk", vtk_of}, {".vtp", vtp_of}};

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
  if (extension_of(path) != ".ply") {
    throw Error("cannot read the mesh " + quoted(path), "only .ply holds a simplex mesh that can be read",
                "name a .ply file");
  }
  SimplexMesh mesh = mesh_of_ply(read_bytes(path), quoted(path));
  try {
    validate(mesh);
  } catch (const Error& invalid) {
    throw Error("cannot read " + quoted(path), std::string("its mesh is not valid: ") + invalid.what(),
                "save it again from the program that made it");
  }
  return mesh;
}

}  // namespace simplexseg
