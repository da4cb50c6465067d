// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <sstream>

#include "core/error.h"
#include "io/source/volume_source.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/image.h"

namespace simplexseg::python {
namespace {

Eigen::Matrix4d affine_lps(const VolumeGeometry& geometry) { return geometry.world_from_index().matrix(); }

Eigen::Matrix4d flipped(const Eigen::Matrix4d& affine) {  // converts an affine from RAS to LPS or from LPS to RAS
  return kLpsFromRas.homogeneous().asDiagonal() * affine;
}

VolumeGeometry geometry_of_affine(const Eigen::Matrix4d& affine, const char* what) {
  if (affine.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw Error(what, "its last row is not 0, 0, 0, 1", "use a matrix from voxel indices to mm");
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
                           const py::object& origin, const py::object& direction, const std::optional<Image>& like) {
  const bool parts = !spacing.is_none() || !origin.is_none() || !direction.is_none();
  if (int(!lps.is_none()) + int(!ras.is_none()) + int(parts) + int(like.has_value()) > 1)
    throw Error("volume", "its geometry is defined twice",
                "use only one of affine_lps, affine_ras, like, or spacing, origin and direction");
  if (like) return like->volume.geometry();
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
  py::class_<Image>(
      module, "Volume",
      "Voxels on a grid in the patient frame (LPS, mm). Indexed [i, j, k] as in nibabel, i fastest in memory. "
      "Immutable.")
      .def(
          py::init([](const py::object& array, const py::object& lps, const py::object& ras, const py::object& spacing,
                      const py::object& origin, const py::object& direction, const std::optional<Image>& like) {
            return Image{volume_of(array, geometry_of(lps, ras, spacing, origin, direction, like))};
          }),
          py::arg("array"), py::kw_only(), py::arg("affine_lps") = py::none(), py::arg("affine_ras") = py::none(),
          py::arg("spacing") = py::none(), py::arg("origin") = py::none(), py::arg("direction") = py::none(),
          py::arg("like") = py::none(),
          "Copies an array [i, j, k] of any memory layout and byte order. Converts bool to uint8, float16 to float32 "
          "and\n"
          "64-bit integers to 32-bit integers. affine_lps: 4 x 4, from voxel indices to mm in LPS; affine_ras: to mm\n"
          "in RAS, like the affine of nibabel. Alternatively spacing, origin (mm, LPS) and direction (3 x 3, columns:\n"
          "directions of i, j, k), as in SimpleITK. Or like: a volume whose geometry is used; if both have the same\n"
          "shape, write_volume() and write_labels() also repeat the header of its file, so that other programs place\n"
          "both alike. Default: spacing 1 mm, origin (0, 0, 0). Raises Error for an array without three axes, an\n"
          "unsupported type, integers above 32 bits, a geometry that cannot be inverted, and if memory does not "
          "suffice.")
      .def_property_readonly("array", &voxels_of, "Voxels [i, j, k]; read-only, not copied.")
      .def(
          "__array__",
          [](const Image& image, const py::object& dtype) -> py::object {
            py::array voxels = voxels_of(image);
            if (dtype.is_none()) return voxels;
            return voxels.attr("astype")(dtype);
          },
          py::arg("dtype") = py::none(), "Supports numpy.asarray(volume).")
      .def_property_readonly(
          "shape",
          [](const Image& image) {
            const auto& size = image.volume.geometry().size;
            return py::make_tuple(size[0], size[1], size[2]);
          },
          "Number of voxels along i, j, k.")
      .def_property_readonly(
          "dtype", [](const Image& image) { return dtype_of(image.volume.type()); }, "Type of the voxels.")
      .def_property_readonly(
          "spacing", [](const Image& image) { return tuple_of(image.volume.geometry().spacing_mm); },
          "Spacing of the voxels along i, j, k, mm.")
      .def_property_readonly(
          "origin", [](const Image& image) { return tuple_of(image.volume.geometry().origin_mm); },
          "Centre of voxel [0, 0, 0], mm, LPS.")
      .def_property_readonly(
          "direction", [](const Image& image) { return array_of(image.volume.geometry().direction); },
          "Matrix 3 x 3; its columns are the directions of i, j, k in LPS.")
      .def_property_readonly(
          "affine_lps", [](const Image& image) { return array_of(affine_lps(image.volume.geometry())); },
          "Matrix 4 x 4 from voxel indices to mm in LPS.")
      .def_property_readonly(
          "affine_ras", [](const Image& image) { return array_of(flipped(affine_lps(image.volume.geometry()))); },
          "Matrix 4 x 4 from voxel indices to mm in RAS, like the affine of nibabel.")
      .def_property_readonly(
          "centre", [](const Image& image) { return tuple_of(image.volume.geometry().centre_mm()); },
          "Centre of the grid, mm, LPS.")
      .def_property_readonly(
          "path", [](const Image& image) { return image.path.empty() ? std::nullopt : std::optional(image.path); },
          "File of the volume; None if it was created from an array.")
      .def(
          "lps_from_index",
          [](const Image& image, const py::object& index) {
            return map_points(image.volume.geometry().world_from_index(), index, "index");
          },
          py::arg("index"), "Converts indices [..., 3], which may be fractional, to positions in mm (LPS).")
      .def(
          "index_from_lps",
          [](const Image& image, const py::object& points) {
            return map_points(image.volume.geometry().index_from_world(), points, "points");
          },
          py::arg("points"), "Converts positions [..., 3] in mm (LPS) to fractional indices.")
      .def(
          "same_grid",
          [](const Image& image, const Image& other) {
            return image.volume.geometry().same_grid(other.volume.geometry());
          },
          py::arg("other"), "Returns True if both grids have the same size and agree within 0.01 voxels.")
      .def("__repr__", &described);
}

}  // namespace simplexseg::python
