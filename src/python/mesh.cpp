// SPDX-License-Identifier: Apache-2.0
#include "python/mesh.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cmath>
#include <optional>

#include "image/label_surface.h"
#include "image/object_axes.h"
#include "image/rasterise.h"
#include "io/labels/label_mesh.h"
#include "io/mesh/mesh_io.h"
#include "mesh/mesh_geometry.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/image.h"
#include "python/interruptible.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxSphereLevel = 9;  ///< subdivision level with 5 million vertices
constexpr int kMinVertices = 4, kMaxVertices = 50000000;

static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
static_assert(sizeof(std::array<int, 3>) == 3 * sizeof(int));

template <class T, class Row>
py::array rows_of(std::shared_ptr<const void> owner, const std::vector<Row>& rows) {
  return view_of(std::move(owner), rows.data(), py::dtype::of<T>(), {static_cast<py::ssize_t>(rows.size()), 3});
}

/// Converts an array (n, 3) to n rows of T. `kinds`: accepted kinds of numpy types, one letter each.
template <class Row, class T>
std::vector<Row> to_rows(const py::object& object, const char* what, const char* kinds) {
  const py::array array = py::array::ensure(object);
  if (!array || array.ndim() != 2 || array.shape(1) != 3 ||
      std::string(kinds).find(array.dtype().kind()) == std::string::npos)
    throw Error(what, "it is not an array (n, 3) of the required type", "use an array of this shape");
  const auto numbers = py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  std::vector<Row> rows(static_cast<std::size_t>(numbers.shape(0)));
  for (std::size_t n = 0; n < rows.size(); ++n)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T value = numbers.data()[3 * n + axis];
      if constexpr (std::is_integral_v<T>)
        if (value < 0 || value > kMaxVertices)
          throw Error(what, "the index " + std::to_string(value) + " is out of range", "count vertices from 0");
      rows[n][static_cast<int>(axis)] = static_cast<std::remove_reference_t<decltype(rows[n][0])>>(value);
    }
  return rows;
}

Surface mesh_of_arrays(const py::object& vertices, const py::object& neighbours) {
  SimplexMesh mesh{to_rows<Eigen::Vector3f, double>(vertices, "vertices", "fiu"),
                   to_rows<std::array<int, 3>, std::int64_t>(neighbours, "neighbours", "iu")};
  const WithoutGil released;
  validate(mesh);
  return Surface(std::move(mesh));
}

Surface mesh_of_triangles(const py::object& points, const py::object& triangles) {
  const TriangleMesh surface{to_rows<Eigen::Vector3f, double>(points, "points", "fiu"),
                             to_rows<std::array<int, 3>, std::int64_t>(triangles, "triangles", "iu")};
  for (const auto& triangle : surface.triangles)
    for (const int corner : triangle)
      if (corner >= static_cast<int>(surface.positions.size()))
        throw Error("triangles", "there is no point " + std::to_string(corner), "count points from 0");
  const WithoutGil released;
  SimplexMesh mesh = dual_of(surface);
  validate(mesh);
  return Surface(std::move(mesh));
}

Surface sphere(const py::object& centre, double radius, int level) {
  const Eigen::Vector3d centre_mm = vector_of(centre, "centre");
  if (!(radius > 0 && std::isfinite(radius))) throw Error("radius", "it is not above 0", "use a radius in mm");
  if (level < 0 || level > kMaxSphereLevel)
    throw Error("level", "it is out of range", "use 0 to " + std::to_string(kMaxSphereLevel));
  return Surface(make_sphere(centre_mm, radius, level));
}

Surface mesh_of_labels(const Image& labels, std::optional<double> label, int part, int vertices) {
  if (label && !std::isfinite(*label)) throw Error("label", "it is not a finite number", "use the value of a label");
  if (part < 0) throw Error("part", "it is negative", "use 1 for the largest part, 0 for all parts");
  if (vertices != 0 && (vertices < kMinVertices || vertices > kMaxVertices))
    throw Error(
        "vertices", "it is out of range",
        "use " + std::to_string(kMinVertices) + " to " + std::to_string(kMaxVertices) + ", or 0 for the default");
  return Surface(mesh_of_mask(choose_label(labels.volume, {label, part, {}}, "labels").mask, vertices));
}

std::optional<py::dict> axes_of(const Surface& surface, const Image& like) {
  const std::optional<ObjectAxes> axes = [&] {
    const WithoutGil released;
    return object_axes(*surface.mesh, like.volume.geometry());
  }();
  if (!axes) return std::nullopt;
  const auto ends_of = [](const std::array<Eigen::Vector3d, 2>& ends) {
    return py::make_tuple(tuple_of(ends[0]), tuple_of(ends[1]));
  };
  py::dict dict;
  dict["long_mm"] = axes->long_mm(), dict["short_mm"] = axes->short_mm();
  dict["long_ends"] = ends_of(axes->long_ends_mm), dict["short_ends"] = ends_of(axes->short_ends_mm);
  dict["slice"] = axes->slice;
  return dict;
}

Image rasterised(const Surface& surface, const Image& like) {
  const Mask mask = rasterise(*surface.mesh, like.volume.geometry());
  Volume volume(mask.geometry, VoxelType::UInt8);
  std::copy(mask.voxels.begin(), mask.voxels.end(), volume.voxels<std::uint8_t>().begin());
  return {std::move(volume)};
}

Image fractions_of(const Surface& surface, const Image& like) {
  Volume volume(like.volume.geometry(), VoxelType::Float32);
  std::ranges::copy(inside_fractions(*surface.mesh, volume.geometry()), volume.voxels<float>().begin());
  return {std::move(volume)};
}

py::tuple tessellated(const Surface& surface) {
  std::shared_ptr<const TriangleMesh> triangles;
  {
    const WithoutGil released;
    triangles = std::make_shared<const TriangleMesh>(tessellate(*surface.mesh));
  }
  return py::make_tuple(rows_of<float>(triangles, triangles->positions), rows_of<int>(triangles, triangles->triangles));
}

}  // namespace

void bind_mesh(py::module_& module) {
  const auto measures = [](auto member) {
    return [member](const Surface& surface) { return measure(*surface.mesh).*member; };
  };
  py::class_<Surface>(module, "Mesh",
                      "Closed 2-simplex mesh: each vertex has three neighbours. Positions are in mm, LPS. Immutable.")
      .def(py::init(&mesh_of_arrays), py::arg("vertices"), py::arg("neighbours"),
           "vertices: (V, 3), mm, LPS; neighbours: (V, 3) indices, counter-clockwise seen from outside. Raises Error, "
           "with\n"
           "the first invalid vertex, if the mesh is not closed.")
      .def_static(
          "from_triangles", &mesh_of_triangles, py::arg("points"), py::arg("triangles"),
          "Returns the dual of a closed triangulation, with one vertex per triangle. points: (P, 3), mm, LPS; "
          "triangles:\n"
          "(T, 3) indices, counter-clockwise seen from outside. Raises Error if the triangulation is not closed.")
      .def_static("sphere", &sphere, py::arg("centre"), py::arg("radius"), py::arg("level") = 2,
                  "Returns a sphere with 20 * 4^level vertices. centre, radius: mm, LPS; level: 0 to 9. Raises Error.")
      .def_property_readonly(
          "vertices", [](const Surface& s) { return rows_of<float>(s.mesh, s.mesh->positions); },
          "Positions (V, 3) float32, mm, LPS; read-only, not copied.")
      .def_property_readonly(
          "neighbours", [](const Surface& s) { return rows_of<int>(s.mesh, s.mesh->neighbours); },
          "Indices (V, 3) int32 of the three neighbours of each vertex; read-only, not copied.")
      .def("tessellate", &tessellated,
           "Returns a triangulation (points, triangles). points: (V + F, 3) float32, mm, LPS, first the vertices, then "
           "the\n"
           "centres of the F cells; triangles: (3 V, 3) int32, counter-clockwise seen from outside.")
      .def("rasterise", &rasterised, py::arg("like"), py::call_guard<WithoutGil>(),
           "Returns a mask (uint8) on the grid of a volume: 1 if the centre of the voxel lies inside the mesh, else 0.")
      .def("fractions", &fractions_of, py::arg("like"), py::call_guard<WithoutGil>(),
           "Returns the fraction (float32, 0..1) of each voxel inside the mesh, on the grid of a volume: "
           "partial-volume\n"
           "labels.")
      .def("axes", &axes_of, py::arg("like"),
           "Returns long and short axis of the object as RECIST 1.1 defines them, as a dict, or None if no slice cuts "
           "the\n"
           "mesh: long_mm, the longest diameter in any axial slice of a volume; short_mm, the longest diameter "
           "perpendicular\n"
           "to it in that slice; long_ends, short_ends: their ends, mm, LPS; slice: its number, from 1, the lowest.")
      .def_property_readonly("volume_mm3", measures(&SurfaceMeasures::volume_mm3), "Enclosed volume.")
      .def_property_readonly("area_mm2", measures(&SurfaceMeasures::area_mm2), "Area of the surface.")
      .def_property_readonly("mean_edge_mm", measures(&SurfaceMeasures::mean_edge_mm), "Mean length of the edges.")
      .def_property_readonly(
          "centroid", [](const Surface& s) { return tuple_of(measure(*s.mesh).centroid_mm); },
          "Centroid of the enclosed solid, mm, LPS.")
      .def(
          "__len__", [](const Surface& s) { return s.mesh->vertex_count(); }, "Number of vertices.")
      .def("__repr__", [](const Surface& s) {
        return "<simplexseg.Mesh of " + std::to_string(s.mesh->vertex_count()) + " vertices>";
      });
  module.def(
      "read_mesh", [](const fs::path& path) { return interruptible([&] { return Surface(read_mesh(path)); }); },
      py::arg("path"),
      "Reads a simplex mesh without loss, or converts a closed surface: .ply, .obj, .stl, .vtk or .vtp. Raises Error\n"
      "if the file is damaged or the surface is not closed.");
  module.def(
      "write_mesh", [](const fs::path& path, const Surface& surface) { write_mesh(path, *surface.mesh); },
      py::arg("path"), py::arg("mesh"), py::call_guard<WithoutGil>(),
      "Writes .ply (lossless), .obj, .stl, .vtk, .vtp, .3mf or .glb atomically. Raises Error if the file cannot be "
      "written.");
  module.def(
      "mesh_from_labels", &mesh_of_labels, py::arg("labels"), py::arg("label") = py::none(), py::kw_only(),
      py::arg("part") = 0, py::arg("vertices") = 0, py::call_guard<WithoutGil>(),
      "Returns the surface of a label as a mesh. label: None for all voxels that are not 0; part: number of the\n"
      "connected part, 1 for the largest, 0 for all parts; vertices: approximate number, 0 for the default.\n"
      "Raises Error if the label or the part does not exist.");
}

}  // namespace simplexseg::python
