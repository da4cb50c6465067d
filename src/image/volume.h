// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>

#include "core/expect.h"

namespace simplexseg {

struct StoredHeader;  // io/source/stored_header.h

/// Types in which the voxels of a volume are stored. No float copy of a volume is created.
enum class VoxelType : std::uint8_t { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

std::size_t bytes_per_voxel(VoxelType type);
/// Name of a type: "int8" ... "float64".
const char* to_string(VoxelType type);
template <class T>
constexpr VoxelType voxel_type_of();

/// Grid of voxels in the patient frame (LPS, mm), as in ITK: world = origin + direction * (spacing .* index), where
/// index (0,0,0) is the centre of the first voxel. `direction` may be any invertible matrix (left-handed, sheared).
struct VolumeGeometry {
  std::array<int, 3> size{0, 0, 0};                         ///< number of voxels along i, j, k
  Eigen::Vector3d spacing_mm{1, 1, 1};                      ///< voxel spacing along i, j, k, from 1e-9 to 1e6
  Eigen::Vector3d origin_mm{0, 0, 0};                       ///< centre of voxel (0,0,0), from -1e12 to 1e12
  Eigen::Matrix3d direction = Eigen::Matrix3d::Identity();  ///< columns: directions of the axes i, j, k
  /// Statement of this grid in the header of its file, repeated in labels on the same grid; nullptr without a file.
  std::shared_ptr<const StoredHeader> header{};

  Eigen::Affine3d world_from_index() const;
  Eigen::Affine3d index_from_world() const;
  std::size_t voxel_count() const;
  Eigen::Vector3d centre_mm() const;
  /// True if the point lies within the outer faces of the outermost voxels.
  bool contains(const Eigen::Vector3d& world_mm) const;
  /// True if the sizes are equal and the voxel centres at all corners agree within `tolerance` voxels.
  bool same_grid(const VolumeGeometry& other, double tolerance = 1e-2) const;
  /// Sets the spacing along an axis (mm). A negative step reverses the direction of the axis.
  void set_step(int axis, double step_mm);
  /// Throws Error if a size is < 1, there are more than 2^48 voxels, the spacing or origin is not finite or out of
  /// range, or the direction is singular or has elements beyond 1e6. `name`: name of the volume in the message.
  void validate(const std::string& name) const;
};

/// Voxels in their stored type, i fastest, with their geometry. Copies share the voxels. Only the code that creates a
/// volume may write through `voxels<T>()`, before the first copy.
class Volume {
 public:
  Volume() = default;
  /// Creates a volume of zeros. Throws Error if the geometry is not valid or the voxels do not fit in memory.
  Volume(VolumeGeometry geometry, VoxelType type);

  const VolumeGeometry& geometry() const { return geometry_; }
  VoxelType type() const { return type_; }
  bool empty() const { return !data_; }
  std::size_t bytes() const { return geometry_.voxel_count() * bytes_per_voxel(type_); }
  const void* data() const { return data_.get(); }
  void* data() { return data_.get(); }
  /// Voxels as type T, which must match type().
  template <class T>
  std::span<T> voxels() {
    SIMPLEXSEG_EXPECT(empty() || voxel_type_of<T>() == type_);
    return {static_cast<T*>(data()), geometry_.voxel_count()};
  }
  template <class T>
  std::span<const T> voxels() const {
    SIMPLEXSEG_EXPECT(empty() || voxel_type_of<T>() == type_);
    return {static_cast<const T*>(data()), geometry_.voxel_count()};
  }

  std::size_t offset(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * geometry_.size[1] + j) * geometry_.size[0] + i;
  }
  /// Value of a voxel. The indices must lie in the grid.
  double value(int i, int j, int k) const;
  /// Trilinear interpolation at a world position (mm), clamped to the grid. The volume must not be empty.
  double sample(const Eigen::Vector3d& world_mm) const;
  struct Range {
    double min, max;
  };
  /// Range of the finite voxels; {0, 0} without a finite voxel.
  Range range() const;

 private:
  VolumeGeometry geometry_;
  VoxelType type_ = VoxelType::UInt8;
  std::shared_ptr<std::byte[]> data_;
};

/// Calls f(std::type_identity<T>{}), where T is the C++ type for `type`, and returns its result.
template <class F>
decltype(auto) visit_voxel_type(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::Int8:
      return f(std::type_identity<std::int8_t>{});
    case VoxelType::UInt8:
      return f(std::type_identity<std::uint8_t>{});
    case VoxelType::Int16:
      return f(std::type_identity<std::int16_t>{});
    case VoxelType::UInt16:
      return f(std::type_identity<std::uint16_t>{});
    case VoxelType::Int32:
      return f(std::type_identity<std::int32_t>{});
    case VoxelType::UInt32:
      return f(std::type_identity<std::uint32_t>{});
    case VoxelType::Float32:
      return f(std::type_identity<float>{});
    case VoxelType::Float64:
      break;
  }
  return f(std::type_identity<double>{});
}

template <>
constexpr VoxelType voxel_type_of<std::int8_t>() {
  return VoxelType::Int8;
}
template <>
constexpr VoxelType voxel_type_of<std::uint8_t>() {
  return VoxelType::UInt8;
}
template <>
constexpr VoxelType voxel_type_of<std::int16_t>() {
  return VoxelType::Int16;
}
template <>
constexpr VoxelType voxel_type_of<std::uint16_t>() {
  return VoxelType::UInt16;
}
template <>
constexpr VoxelType voxel_type_of<std::int32_t>() {
  return VoxelType::Int32;
}
template <>
constexpr VoxelType voxel_type_of<std::uint32_t>() {
  return VoxelType::UInt32;
}
template <>
constexpr VoxelType voxel_type_of<float>() {
  return VoxelType::Float32;
}
template <>
constexpr VoxelType voxel_type_of<double>() {
  return VoxelType::Float64;
}

}  // namespace simplexseg
