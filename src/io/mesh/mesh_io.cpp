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

/// Format of files with several surfaces, which are not read.
struct SeveralFormat {
  const char* extension;
  std::string (*bytes_of)(std::span<const NamedSurface>);
};
constexpr SeveralFormat kSeveralFormats[] = {{".3mf", three_mf_of}, {".glb", glb_of}};

const SeveralFormat* several_format_of(const fs::path& path) {
  const std::string extension = extension_of(path);
  for (const SeveralFormat& format : kSeveralFormats)
    if (extension == format.extension) return &format;
  return nullptr;
}

void require_surface(const fs::path& path, const SimplexMesh& mesh) {
  if (mesh.positions.empty() || mesh.positions.size() != mesh.neighbours.size())
    throw Error("cannot write the mesh " + quoted(path), "it is empty or incomplete", "create a segmentation first");
}

void write_whole(const fs::path& path, const std::string& bytes) {
  AtomicFile file(path);
  write_bytes(file, bytes);
  file.commit();
}

/// Format of an extension; nullptr if it is not supported.
const Format* format_of(const fs::path& path) {
  const std::string extension = extension_of(path);
  const auto format =
      std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& f) { return extension == f.extension; });
  return format == std::end(kFormats) ? nullptr : format;
}

}  // namespace

bool is_mesh_name(const fs::path& path) { return format_of(path) != nullptr; }

bool holds_several_surfaces(const fs::path& path) { return several_format_of(path) != nullptr; }

void require_mesh_name(const fs::path& path) {
  if (extension_of(path) == ".3mf") require_three_mf();
  if (is_mesh_name(path) || holds_several_surfaces(path)) return;
  throw Error("cannot write the mesh " + quoted(path),
              "the extension '" + one_line(extension_of(path)) + "' is not supported",
              "use .ply (lossless), .obj, .stl, .vtk, .vtp, .3mf or .glb");
}

void write_mesh(const fs::path& path, const SimplexMesh& mesh) {
  require_mesh_name(path);
  require_surface(path, mesh);
  if (holds_several_surfaces(path)) {
    const NamedSurface surface{.name = path.stem().string(), .mesh = &mesh};
    write_surfaces(path, {&surface, 1});
  } else {
    write_whole(path, format_of(path)->bytes_of(mesh));
  }
}

void write_surfaces(const fs::path& path, std::span<const NamedSurface> surfaces) {
  const SeveralFormat* const format = several_format_of(path);
  if (!format)
    throw Error("cannot write the meshes " + quoted(path),
                "the extension '" + one_line(extension_of(path)) + "' holds one mesh", "use .3mf or .glb");
  require_mesh_name(path);
  if (surfaces.empty())
    throw Error("cannot write the meshes " + quoted(path), "there is none", "create a segmentation first");
  for (const NamedSurface& surface : surfaces) require_surface(path, *surface.mesh);
  write_whole(path, format->bytes_of(surfaces));
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
