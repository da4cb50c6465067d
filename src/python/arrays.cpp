// SPDX-License-Identifier: Apache-2.0
#include "python/arrays.h"

#include <limits>
#include <string>

#include "core/error.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"

namespace simplexseg::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string name_of(const py::dtype& dtype) { return py::str(static_cast<py::object>(dtype)); }

/// Returns the numbers of an object as an array of double; null if it contains no numbers.
Numbers numbers_of(const py::handle& object) {
  const py::array array = py::array::ensure(object);
  if (!array || std::string("biuf").find(array.dtype().kind()) == std::string::npos) return Numbers::ensure(py::none());
  return Numbers::ensure(array);
}

/// Returns the 32-bit type that represents all values of an array of 64-bit integers.
VoxelType narrow_type(const py::array& array) {
  const py::int_ low(array.attr("min")()), high(array.attr("max")());
  const auto fits = [&](auto minimum, auto maximum) { return low >= py::int_(minimum) && high <= py::int_(maximum); };
  if (fits(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max())) return VoxelType::Int32;
  if (fits(0, std::numeric_limits<std::uint32_t>::max())) return VoxelType::UInt32;
  throw Error("array", "its 64-bit integers do not fit into 32 bits", "use float32, float64 or 32-bit integers");
}

VoxelType voxel_type_of(const py::array& array) {
  const char kind = array.dtype().kind();
  const auto bytes = array.itemsize();
  if (kind == 'b') return VoxelType::UInt8;
  if ((kind == 'i' || kind == 'u') && bytes == 8) return narrow_type(array);
  if (kind == 'i') return bytes == 1 ? VoxelType::Int8 : bytes == 2 ? VoxelType::Int16 : VoxelType::Int32;
  if (kind == 'u') return bytes == 1 ? VoxelType::UInt8 : bytes == 2 ? VoxelType::UInt16 : VoxelType::UInt32;
  if (kind == 'f' && bytes <= 4) return VoxelType::Float32;
  if (kind == 'f' && bytes == 8) return VoxelType::Float64;
  throw Error("array", "its type is " + name_of(array.dtype()), "use integers, float32 or float64");
}

Shape strides_of(const Shape& shape, py::ssize_t item, bool first_is_fastest) {
  Shape strides(shape.size());
  for (std::size_t n = 0; n < shape.size(); ++n) {
    const std::size_t axis = first_is_fastest ? n : shape.size() - 1 - n;
    strides[axis] = item;
    item *= shape[axis];
  }
  return strides;
}

}  // namespace

py::dtype dtype_of(VoxelType type) { return py::dtype(to_string(type)); }

py::array view_of(std::shared_ptr<const void> owner, const void* data, const py::dtype& dtype, const Shape& shape,
                  bool first_is_fastest) {
  const py::capsule base(new std::shared_ptr<const void>(std::move(owner)),
                         [](void* pointer) { delete static_cast<std::shared_ptr<const void>*>(pointer); });
  py::array array(dtype, shape, strides_of(shape, dtype.itemsize(), first_is_fastest), data, base);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

Volume volume_of(const py::object& object, VolumeGeometry geometry) {
  const py::array array = py::array::ensure(object);
  if (!array) throw Error("array", "it cannot be converted to an array", "use a numpy array");
  if (array.ndim() != 3)
    throw Error("array", "it has " + std::to_string(array.ndim()) + " axes", "use three axes: [i, j, k]");
  for (int axis = 0; axis < 3; ++axis) {
    if (array.shape(axis) < 1 || array.shape(axis) > std::numeric_limits<int>::max())
      throw Error("array", "axis " + std::to_string(axis) + " has " + std::to_string(array.shape(axis)) + " voxels",
                  "use 1 to 2147483647");
    geometry.size[axis] = static_cast<int>(array.shape(axis));
  }
  geometry.validate("volume");
  const VoxelType type = voxel_type_of(array);
  const double needed = double(geometry.voxel_count()) * double(bytes_per_voxel(type));
  if (const std::size_t available = available_memory(); available > 0 && needed > double(available))
    throw Error("array",
                "it needs " + format_bytes(needed) + " of memory, but only " + format_bytes(double(available)) +
                    " are available",
                "crop or downsample it");
  Volume volume(geometry, type);
  const Shape shape(array.shape(), array.shape() + 3);
  const py::capsule not_owned(volume.data(), [](void*) {});
  const py::dtype dtype = dtype_of(type);
  const py::array voxels(dtype, shape, strides_of(shape, dtype.itemsize(), true), volume.data(), not_owned);
  py::module_::import("numpy").attr("copyto")(voxels, array, py::arg("casting") = "unsafe");
  return volume;
}

Eigen::Vector3d vector_of(const py::handle& object, const char* what) {
  const Numbers numbers = numbers_of(object);
  if (!numbers || numbers.ndim() != 1 || numbers.shape(0) != 3)
    throw Error(what, "it is not three numbers", "use (x, y, z)");
  Eigen::Vector3d v(numbers.at(0), numbers.at(1), numbers.at(2));
  if (!v.allFinite()) throw Error(what, "a value is not finite", "use finite numbers");
  return v;
}

Eigen::MatrixXd matrix_of(const py::handle& object, int rows, int columns, const char* what) {
  const std::string shape = std::to_string(rows) + " x " + std::to_string(columns);
  const Numbers numbers = numbers_of(object);
  if (!numbers || numbers.ndim() != 2 || numbers.shape(0) != rows || numbers.shape(1) != columns)
    throw Error(what, "it is not a matrix of " + shape + " numbers", "use a matrix of this shape");
  Eigen::MatrixXd matrix(rows, columns);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) matrix(r, c) = numbers.at(r, c);
  if (!matrix.allFinite()) throw Error(what, "a value is not finite", "use finite numbers");
  return matrix;
}

py::tuple tuple_of(const Eigen::Vector3d& v) { return py::make_tuple(v.x(), v.y(), v.z()); }

py::array_t<double> array_of(const Eigen::MatrixXd& matrix) {
  py::array_t<double> array(Shape{matrix.rows(), matrix.cols()});
  auto numbers = array.mutable_unchecked<2>();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) numbers(r, c) = matrix(r, c);
  return array;
}

py::array_t<double> map_points(const Eigen::Affine3d& map, const py::object& points, const char* what) {
  const Numbers from = numbers_of(points);
  if (!from || from.ndim() < 1 || from.shape(from.ndim() - 1) != 3)
    throw Error(what, "its last axis does not have three numbers", "use an array of the shape (..., 3)");
  py::array_t<double> to(Shape(from.shape(), from.shape() + from.ndim()));
  const double* const in = from.data();
  double* const out = to.mutable_data();
  for (py::ssize_t n = 0; n < from.size(); n += 3)
    Eigen::Map<Eigen::Vector3d>(out + n) = map * Eigen::Vector3d(in[n], in[n + 1], in[n + 2]);
  return to;
}

}  // namespace simplexseg::python
