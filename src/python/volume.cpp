// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <sstream>

#include "core/error.h"
#include "io/volume_source.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/image.h"

namespace simplexseg::python {
namespace {

Eigen::Matrix4d affine_lps(const VolumeGeometry& geometry) { return geometry.world_from_index().matrix(); }

Eigen::Matrix4d flipped(const Eigen::Matrix4d& affine) {  // from RAS to LPS, and back
  return kLpsFromRas.homogeneous().asDiagonal() * affine;
}

VolumeGeometry geometry_of_affine(const Eigen::Matrix4d& affine, const char* what) {
  if (affine.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw Error(what, "its last row is not 0, 0, 0, 1", "give millimetres from voxel indices");
  VolumeGeometry geometry;
  geometry.origin_mm = affine.topRightCorner<3, 1>();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = affine.block<3, 1>(0, axis);
    geometry.spacing_mm[axis] = step.norm();
    if (step.norm() > 0) geometry.direction.col(axis) = step / step.norm();
  }
  return geometry;
}

VolumeGeometry geometry_of(const py::object& lps, const py::object& ras, const py::object& spacing,
                           const py::object& origin, const py::object& direction) {
  const bool parts = !spacing.is_none() || !origin.is_none() || !direction.is_none();
  if (int(!lps.is_none()) + int(!ras.is_none()) + int(parts) > 1)
    throw Error("volume", "its geometry is given twice",
                "give one of affine_lps, affine_ras, or spacing, origin and direction");
  if (!lps.is_none()) return geometry_of_affine(matrix_of(lps, 4, 4, "affine_lps"), "affine_lps");
  if (!ras.is_none()) return geometry_of_affine(flipped(matrix_of(ras, 4, 4, "affine_ras")), "affine_ras");
  VolumeGeometry geometry;
  if (!spacing.is_none()) geometry.spacing_mm = vector_of(spacing, "spacing");
  if (!origin.is_none()) geometry.origin_mm = vector_of(origin, "origin");
  if (!direction.is_none()) geometry.direction = matrix_of(direction, 3, 3, "direction");
  return geometry;
}

py::array voxels_of(const Image& image) {
  const auto& size = image.volume.geometry().size;
  const auto owner = std::make_shared<const Volume>(image.volume);
  return view_of(owner, owner->data(), dtype_of(owner->type()), {size[0], size[1], size[2]}, true);
}

std::string described(const Image& image) {
  const VolumeGeometry& g = image.volume.geometry();
  std::ostringstream text;
  text << "<simplexseg.Volume " << g.size[0] << " x " << g.size[1] << " x " << g.size[2] << ", "
       << to_string(image.volume.type()) << ", spacing " << g.spacing_mm[0] << " x " << g.spacing_mm[1] << " x "
       << g.spacing_mm[2] << " mm>";
  return text.str();
}

}  // namespace

void bind_volume(py::module_& module) {
  py::class_<Image>(module, "Volume",
                    "Voxels on a grid in the patient frame (LPS, mm). Indexed [i, j, k], i fastest in memory, as "
                    "nibabel's arrays are; immutable.")
      .def(py::init([](const py::object& array, const py::object& lps, const py::object& ras, const py::object& spacing,
                       const py::object& origin, const py::object& direction) {
             return Image{volume_of(array, geometry_of(lps, ras, spacing, origin, direction))};
           }),
           py::arg("array"), py::kw_only(), py::arg("affine_lps") = py::none(), py::arg("affine_ras") = py::none(),
           py::arg("spacing") = py::none(), py::arg("origin") = py::none(), py::arg("direction") = py::none(),
           "A copy of an array [i, j, k] of whatever memory layout and byte order. bool becomes uint8, float16\n"
           "float32, 64-bit integers 32-bit ones. affine_lps: 4 x 4, millimetres in LPS from voxel indices;\n"
           "affine_ras: the same in RAS, as nibabel has it; or spacing, origin (mm, LPS) and direction (3 x 3, its\n"
           "columns are the directions of i, j, k), as SimpleITK has them. Without any: 1 mm, from (0, 0, 0) on.\n"
           "Raises Error for another number of axes, a type or integers that cannot be kept, a geometry that cannot\n"
           "be inverted, and where memory does not suffice.")
      .def_property_readonly("array", &voxels_of, "The voxels [i, j, k], read-only, not copied.")
      .def(
          "__array__",
          [](const Image& image, const py::object& dtype) -> py::object {
            py::array voxels = voxels_of(image);
            if (dtype.is_none()) return voxels;
            return voxels.attr("astype")(dtype);
          },
          py::arg("dtype") = py::none(), "For numpy.asarray(volume).")
      .def_property_readonly(
          "shape",
          [](const Image& image) {
            const auto& size = image.volume.geometry().size;
            return py::make_tuple(size[0], size[1], size[2]);
          },
          "Voxels along i, j, k.")
      .def_property_readonly(
          "dtype", [](const Image& image) { return dtype_of(image.volume.type()); }, "Type of the voxels.")
      .def_property_readonly(
          "spacing", [](const Image& image) { return tuple_of(image.volume.geometry().spacing_mm); },
          "Distances of voxels along i, j, k, mm.")
      .def_property_readonly(
          "origin", [](const Image& image) { return tuple_of(image.volume.geometry().origin_mm); },
          "Centre of voxel [0, 0, 0], mm, LPS.")
      .def_property_readonly(
          "direction", [](const Image& image) { return array_of(image.volume.geometry().direction); },
          "3 x 3; its columns are the directions of i, j, k in LPS.")
      .def_property_readonly(
          "affine_lps", [](const Image& image) { return array_of(affine_lps(image.volume.geometry())); },
          "4 x 4: millimetres in LPS from voxel indices.")
      .def_property_readonly(
          "affine_ras", [](const Image& image) { return array_of(flipped(affine_lps(image.volume.geometry()))); },
          "4 x 4: millimetres in RAS from voxel indices, as nibabel's affine.")
      .def_property_readonly(
          "centre", [](const Image& image) { return tuple_of(image.volume.geometry().centre_mm()); },
          "Middle of the grid, mm, LPS.")
      .def_property_readonly(
          "path", [](const Image& image) { return image.path.empty() ? std::nullopt : std::optional(image.path); },
          "The file that it was read from; None where it was made of an array.")
      .def(
          "lps_from_index",
          [](const Image& image, const py::object& index) {
            return map_points(image.volume.geometry().world_from_index(), index, "index");
          },
          py::arg("index"), "Positions in mm (LPS) of indices [..., 3], which need not be whole.")
      .def(
          "index_from_lps",
          [](const Image& image, const py::object& points) {
            return map_points(image.volume.geometry().index_from_world(), points, "points");
          },
          py::arg("points"), "Indices, not rounded, of positions [..., 3] in mm (LPS).")
      .def(
          "same_grid",
          [](const Image& image, const Image& other) {
            return image.volume.geometry().same_grid(other.volume.geometry());
          },
          py::arg("other"),
          "Whether both have as many voxels and these lie within a hundredth of a voxel of each other.")
      .def("__repr__", &described);
}

}  // namespace simplexseg::python
