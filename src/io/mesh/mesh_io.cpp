// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/mesh_io.h"

#include <algorithm>
#include <string>

#include "io/mesh/mesh_formats.h"
#include "io/mesh/ply.h"
#include "io/mesh/surface_formats.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

struct Format {
  const char* extension;
  std::string (*bytes_of)(const SimplexMesh&);
  PolygonSurface (*surface_of)(const std::string& bytes, const Fail& fail);  ///< nullptr: use mesh_of_ply()
};
constexpr Format kFormats[] = {{".ply", ply_of, nullptr},
                               {".obj", obj_of, surface_of_obj},
                               {".stl", stl_of, surface_of_stl},
                               {".vtk", vtk_of, surface_of_vtk},
                               {".vtp", vtp_of, surface_of_vtp}};

/// Format of an extension; nullptr if it is not supported.
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
              "the extension '" + one_line(extension_of(path)) + "' is not supported",
              "use .ply (lossless), .obj, .stl, .vtk or .vtp");
}

void write_mesh(const fs::path& path, const SimplexMesh& mesh) {
  require_mesh_name(path);
  if (mesh.positions.empty() || mesh.positions.size() != mesh.neighbours.size()) {
    throw Error("cannot write the mesh " + quoted(path), "it is empty or incomplete", "create a segmentation first");
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
                "the extension '" + one_line(extension_of(path)) + "' is not supported",
                "use .ply, .obj, .stl, .vtk or .vtp");
  }
  const Fail fail = [&](const std::string& why) {
    throw Error("cannot read " + quoted(path), why, "export it again as a closed surface in .stl, .obj or .ply format");
  };
  const std::string bytes = read_bytes(path);
  SimplexMesh mesh =
      format->surface_of ? simplex_mesh_of(format->surface_of(bytes, fail), fail) : mesh_of_ply(bytes, quoted(path));
  try {
    validate(mesh);
  } catch (const Error& invalid) {
    throw Error("cannot read " + quoted(path), std::string("its mesh is not valid: ") + invalid.what(),
                "save it again with the program that created it");
  }
  return mesh;
}

}  // namespace simplexseg
