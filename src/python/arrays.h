// SPDX-License-Identifier: Apache-2.0
// Conversions between numpy arrays and the types of the library.
#pragma once
#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "image/volume.h"

namespace simplexseg::python {

namespace py = pybind11;

/// Sizes of the axes of an array.
using Shape = std::vector<py::ssize_t>;

/// Returns the numpy type of a voxel type.
py::dtype dtype_of(VoxelType type);

/// Returns a read-only array over the memory of `owner`, which the array and its views keep alive. The last axis is the
/// fastest in memory, or the first if `first_is_fastest`.
py::array view_of(std::shared_ptr<const void> owner, const void* data, const py::dtype& dtype, const Shape& shape,
                  bool first_is_fastest = false);

/// Copies an array-like object [i, j, k] of any memory layout and byte order to a Volume. Converts bool to uint8,
/// float16 to float32 and 64-bit integers to 32-bit integers. Throws Error if the object is not an array of numbers
/// with three axes, if an integer exceeds 32 bits, or if memory does not suffice.
Volume volume_of(const py::object& object, VolumeGeometry geometry);

/// Converts an object to three numbers or to a matrix. Throws Error, whose message begins with `what`, for other shapes
/// and for values that are not finite.
Eigen::Vector3d vector_of(const py::handle& object, const char* what);
Eigen::MatrixXd matrix_of(const py::handle& object, int rows, int columns, const char* what);

py::tuple tuple_of(const Eigen::Vector3d& v);
py::array_t<double> array_of(const Eigen::MatrixXd& matrix);

/// Applies `map` to each row of an array (..., 3). Throws Error for other shapes.
py::array_t<double> map_points(const Eigen::Affine3d& map, const py::object& points, const char* what);

}  // namespace simplexseg::python
