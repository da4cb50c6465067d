// SPDX-License-Identifier: Apache-2.0
// Between numpy's arrays and the library's.
#pragma once
#include <pybind11/numpy.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "image/volume.h"

namespace simplexseg::python {

namespace py = pybind11;

/// Axis sizes of an array.
using Shape = std::vector<py::ssize_t>;

py::dtype dtype_of(VoxelType type);

/// A read-only array over the memory of `owner`, which lives as long as the array and every view of it. The last axis
/// is the fastest, or the first where `first_is_fastest`.
py::array view_of(std::shared_ptr<const void> owner, const void* data, const py::dtype& dtype, const Shape& shape,
                  bool first_is_fastest = false);

/// A copy as a Volume, i fastest, of an array-like object [i, j, k] of whatever memory layout and byte order. bool
/// becomes uint8, float16 float32, 64-bit integers 32-bit ones. Throws Error for what is no array of three axes of
/// numbers, for integers that do not fit, and for one that does not fit into memory.
Volume volume_of(const py::object& object, VolumeGeometry geometry);

/// Three numbers, or a matrix of that size. Throws Error, with `what` in front, for anything else and for what is not
/// finite.
Eigen::Vector3d vector_of(const py::handle& object, const char* what);
Eigen::MatrixXd matrix_of(const py::handle& object, int rows, int columns, const char* what);

py::tuple tuple_of(const Eigen::Vector3d& v);
py::array_t<double> array_of(const Eigen::MatrixXd& matrix);

/// `map` of each row of an array (..., 3). Throws Error for another shape.
py::array_t<double> map_points(const Eigen::Affine3d& map, const py::object& points, const char* what);

}  // namespace simplexseg::python
