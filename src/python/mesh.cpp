// SPDX-License-Identifier: Apache-2.0
#include "python/mesh.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <optional>

#include "image/label_surface.h"
#include "image/rasterise.h"
#include "io/label_mesh.h"
#include "io/mesh_io.h"
#include "mesh/mesh_geometry.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/image.h"
#include "python/interruptible.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

constexpr int kMostSphereLevel = 9;  // 5 million vertices
constexpr int kLeastVertices = 4, kMostVertices = 50000000;

static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
static_assert(sizeof(std::array<int, 3>) == 3 * sizeof(int));

template <class T, class Row>
py::array rows_of(std::shared_ptr<const void> owner, const std::vector<Row>& rows) {
  return view_of(std::move(owner), rows.data(), py::dtype::of<T>(), {static_cast<py::ssize_t>(rows.size()), 3});
}

/// Rows of three of an array of numbers that T can hold.
template <class Row, class T>
std::vector<Row> to_rows(const py::object& object, const char* what, const char* kinds) {
  const py::array array = py::array::ensure(object);
  if (!array || array.ndim() != 2 || array.shape(1) != 3 ||
      std::string(kinds).find(array.dtype().kind()) == std::string::npos)
    throw Error(what, "it is no array of rows of three numbers of its kind", "give one of the shape (n, 3)");
  const auto numbers = py::array_t<T, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  std::vector<Row> rows(static_cast<std::size_t>(numbers.shape(0)));
  for (std::size_t n = 0; n < rows.size(); ++n)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const T value = numbers.data()[3 * n + axis];
      if constexpr (std::is_integral_v<T>)
        if (value < 0 || value > kMostVertices)
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
  if (!(radius > 0 && std::isfinite(radius))) throw Error("radius", "it is not above 0", "give millimetres");
  if (level < 0 || level > kMostSphereLevel)
    throw Error("level", "it is out of range", "give 0 to " + std::to_string(kMostSphereLevel));
  return Surface(make_sphere(centre_mm, radius, level));
}

Surface mesh_of_labels(const Image& labels, std::optional<double> label, int part, int vertices) {
  if (label && !std::isfinite(*label)) throw Error("label", "it is not a finite number", "give a label");
  if (part < 0) throw Error("part", "it is below 0", "give 1 for the largest, 0 for all");
  if (vertices != 0 && (vertices < kLeastVertices || vertices > kMostVertices))
    throw Error("vertices", "it is out of range",
                "give " + std::to_string(kLeastVertices) + " to " + std::to_string(kMostVertices) +
                    ", or 0 for as many as suit the voxels");
  return Surface(mesh_of_mask(choose_label(labels.volume, {label, part, {}}, "labels").mask, vertices));
}

Image rasterised(const Surface& surface, const Image& like) {
  const Mask mask = rasterise(*surface.mesh, like.volume.geometry());
  Volume volume(mask.geometry, VoxelType::UInt8);
  std::copy(mask.voxels.begin(), mask.voxels.end(), volume.voxels<std::uint8_t>().begin());
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
                      "A closed 2-simplex mesh: each vertex has three neighbours. Positions are mm in LPS; immutable.")
      .def(py::init(&mesh_of_arrays), py::arg("vertices"), py::arg("neighbours"),
           "vertices: (V, 3), mm, LPS; neighbours: (V, 3) indices, counter-clockwise seen from outside. Raises Error\n"
           "naming the first vertex where that is no closed mesh.")
      .def_static(
          "from_triangles", &mesh_of_triangles, py::arg("points"), py::arg("triangles"),
          "The dual of a closed triangulation: a vertex for each triangle. points: (P, 3), mm, LPS; triangles:\n"
          "(T, 3) indices, counter-clockwise seen from outside. Raises Error for one that is not closed.")
      .def_static("sphere", &sphere, py::arg("centre"), py::arg("radius"), py::arg("level") = 2,
                  "20 * 4^level vertices on a sphere; centre and radius in mm (LPS), level 0 to 9. Raises Error.")
      .def_property_readonly(
          "vertices", [](const Surface& s) { return rows_of<float>(s.mesh, s.mesh->positions); },
          "(V, 3) float32, mm, LPS; read-only, not copied.")
      .def_property_readonly(
          "neighbours", [](const Surface& s) { return rows_of<int>(s.mesh, s.mesh->neighbours); },
          "(V, 3) int32: the three neighbours of each vertex; read-only, not copied.")
      .def("tessellate", &tessellated,
           "Triangles for drawing and for other programs: (points, triangles), (V + F, 3) float32 in mm (LPS), the\n"
           "vertices first, then the centres of the cells, and (3 V, 3) int32, counter-clockwise from outside.")
      .def("rasterise", &rasterised, py::arg("like"), py::call_guard<WithoutGil>(),
           "Volume on the grid of another: 1 where a voxel's centre lies inside, else 0 (uint8).")
      .def_property_readonly("volume_mm3", measures(&SurfaceMeasures::volume_mm3), "Enclosed volume.")
      .def_property_readonly("area_mm2", measures(&SurfaceMeasures::area_mm2), "Area of the surface.")
      .def_property_readonly("mean_edge_mm", measures(&SurfaceMeasures::mean_edge_mm), "Mean length of the edges.")
      .def_property_readonly(
          "centroid", [](const Surface& s) { return tuple_of(measure(*s.mesh).centroid_mm); },
          "Of the enclosed solid, mm, LPS.")
      .def(
          "__len__", [](const Surface& s) { return s.mesh->vertex_count(); }, "How many vertices.")
      .def("__repr__", [](const Surface& s) {
        return "<simplexseg.Mesh of " + std::to_string(s.mesh->vertex_count()) + " vertices>";
      });
  module.def(
      "read_mesh", [](const fs::path& path) { return interruptible([&] { return Surface(read_mesh(path)); }); },
      py::arg("path"),
      "Reads .ply, .obj, .stl, .vtk or .vtp: a simplex mesh to the bit, or a closed surface of another program.\n"
      "Raises Error for what is damaged or not closed.");
  module.def(
      "write_mesh", [](const fs::path& path, const Surface& surface) { write_mesh(path, *surface.mesh); },
      py::arg("path"), py::arg("mesh"), py::call_guard<WithoutGil>(),
      "Writes .ply (which keeps every bit), .obj, .stl, .vtk or .vtp, whole or not at all. Raises Error.");
  module.def("mesh_from_labels", &mesh_of_labels, py::arg("labels"), py::arg("label") = py::none(), py::kw_only(),
             py::arg("part") = 0, py::arg("vertices") = 0, py::call_guard<WithoutGil>(),
             "The surface of a label (None: every voxel that is not 0) as a mesh. part: this connected part alone, 1\n"
             "is the largest; vertices: about so many, 0 for as many as suit the voxels. Raises Error where there is\n"
             "no such voxel or part.");
}

}  // namespace simplexseg::python
