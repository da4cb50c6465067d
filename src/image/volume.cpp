// SPDX-License-Identifier: Apache-2.0
#include "image/volume.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "core/number_text.h"

namespace simplexseg {
namespace {

constexpr double kMinSpacing = 1e-9, kMaxSpacing = 1e6;  // mm; from atomic to city scale
constexpr double kMaxOrigin = 1e12;                      // mm; its square must stay in the range of float
constexpr double kMaxDirection = 1e6;

Eigen::Vector3d last_index(const VolumeGeometry& geometry) {
  return {geometry.size[0] - 1.0, geometry.size[1] - 1.0, geometry.size[2] - 1.0};
}

std::string row_of(const Eigen::Vector3d& v, const char* separator) {
  return general_text(v[0], 6) + separator + general_text(v[1], 6) + separator + general_text(v[2], 6);
}

template <class T>
Volume::Range range_of(std::span<const T> voxels) {
  T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
  for (T v : voxels) {
    if constexpr (std::is_floating_point_v<T>) {
      // Branch-free, so that the loop is vectorised. A voxel that is not finite changes neither bound.
      const bool finite = std::abs(v) <= std::numeric_limits<T>::max();
      low = finite && v < low ? v : low;
      high = finite && v > high ? v : high;
    } else {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  if (low > high) return {0, 0};
  return {static_cast<double>(low), static_cast<double>(high)};
}

}  // namespace

std::size_t bytes_per_voxel(VoxelType type) {
  return visit_voxel_type(type, []<class T>(std::type_identity<T>) { return sizeof(T); });
}

const char* to_string(VoxelType type) {
  switch (type) {
    case VoxelType::Int8:
      return "int8";
    case VoxelType::UInt8:
      return "uint8";
    case VoxelType::Int16:
      return "int16";
    case VoxelType::UInt16:
      return "uint16";
    case VoxelType::Int32:
      return "int32";
    case VoxelType::UInt32:
      return "uint32";
    case VoxelType::Float32:
      return "float32";
    case VoxelType::Float64:
      break;
  }
  return "float64";
}

Eigen::Affine3d VolumeGeometry::world_from_index() const {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() = direction * spacing_mm.asDiagonal();
  affine.translation() = origin_mm;
  return affine;
}

Eigen::Affine3d VolumeGeometry::index_from_world() const { return world_from_index().inverse(); }

std::size_t VolumeGeometry::voxel_count() const {
  return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
}

Eigen::Vector3d VolumeGeometry::centre_mm() const { return world_from_index() * (0.5 * last_index(*this)); }

bool VolumeGeometry::contains(const Eigen::Vector3d& world_mm) const {
  const Eigen::Array3d index = (index_from_world() * world_mm).array();
  return (index >= -0.5).all() && (index <= last_index(*this).array() + 0.5).all();
}

bool VolumeGeometry::same_grid(const VolumeGeometry& other, double tolerance) const {
  if (size != other.size) return false;
  const Eigen::Affine3d index_from_other = index_from_world() * other.world_from_index();
  const Eigen::Vector3d last = last_index(*this);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d index(corner & 1 ? last[0] : 0.0, corner & 2 ? last[1] : 0.0, corner & 4 ? last[2] : 0.0);
    // The negated comparison makes NaN count as different.
    if (!((index_from_other * index - index).norm() <= tolerance)) return false;
  }
  return true;
}

void VolumeGeometry::set_step(int axis, double step_mm) {
  spacing_mm[axis] = std::abs(step_mm);
  if (step_mm < 0) direction.col(axis) *= -1;
}

void VolumeGeometry::validate(const std::string& name) const {
  if (*std::min_element(size.begin(), size.end()) < 1)
    throw Error(name, "it has " + row_of({double(size[0]), double(size[1]), double(size[2])}, " x ") + " voxels",
                "give a volume of at least one voxel along each axis");
  if (double(size[0]) * size[1] * size[2] > 0x1p48)
    throw Error(name,
                "its header states " + row_of({double(size[0]), double(size[1]), double(size[2])}, " x ") + " voxels",
                "check the header, which is probably damaged");
  if (!spacing_mm.allFinite() || spacing_mm.minCoeff() <= 0)
    throw Error(name, "its voxel spacing is " + row_of(spacing_mm, " x ") + " mm",
                "correct the header: each spacing must be finite and above 0");
  if (spacing_mm.minCoeff() < kMinSpacing || spacing_mm.maxCoeff() > kMaxSpacing)
    throw Error(name, "its voxel spacing is " + row_of(spacing_mm, " x ") + " mm",
                "correct the header: each spacing must be from 1e-09 to 1e+06 mm");
  if (!origin_mm.allFinite() || origin_mm.cwiseAbs().maxCoeff() > kMaxOrigin)
    throw Error(name, "its origin (" + row_of(origin_mm, ", ") + ") is not finite or beyond 1e+12 mm",
                "correct the header");
  if (direction.allFinite() && direction.cwiseAbs().maxCoeff() > kMaxDirection)
    throw Error(name, "its direction matrix has elements beyond 1e+06", "correct the header");
  // Compares the determinant with that of orthogonal columns of the same lengths, which is independent of scale.
  const double full = direction.colwise().norm().prod();
  if (!direction.allFinite() || !(std::abs(direction.determinant()) > 1e-6 * full))
    throw Error(name,
                "its direction matrix (" + row_of(direction.row(0), " ") + "; " + row_of(direction.row(1), " ") + "; " +
                    row_of(direction.row(2), " ") + ") cannot be inverted",
                "correct the header");
}

Volume::Volume(VolumeGeometry geometry, VoxelType type) : geometry_(std::move(geometry)), type_(type) {
  geometry_.validate("volume");
  // calloc returns large blocks as untouched zero pages, so a reader that fills them makes only one pass.
  auto* block = static_cast<std::byte*>(std::calloc(geometry_.voxel_count(), bytes_per_voxel(type)));
  if (!block)
    throw Error("volume of " +
                    row_of({double(geometry_.size[0]), double(geometry_.size[1]), double(geometry_.size[2])}, " x ") +
                    " voxels (" + to_string(type) + ")",
                "it does not fit in memory", "crop or downsample it");
  data_ = std::shared_ptr<std::byte[]>(block, [](std::byte* p) { std::free(p); });
}

double Volume::value(int i, int j, int k) const {
  SIMPLEXSEG_EXPECT(!empty() && i >= 0 && j >= 0 && k >= 0);
  SIMPLEXSEG_EXPECT(i < geometry_.size[0] && j < geometry_.size[1] && k < geometry_.size[2]);
  return visit_voxel_type(type_, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(static_cast<const T*>(data())[offset(i, j, k)]);
  });
}

double Volume::sample(const Eigen::Vector3d& world_mm) const {
  SIMPLEXSEG_EXPECT(!empty());
  const Eigen::Vector3d index = geometry_.index_from_world() * world_mm;
  std::array<int, 3> low, high;
  std::array<double, 3> fraction;
  for (int a = 0; a < 3; ++a) {
    const double last = geometry_.size[a] - 1.0;
    const double clamped = index[a] > 0 ? std::min(index[a], last) : 0.0;  // NaN becomes 0
    low[a] = static_cast<int>(clamped);
    fraction[a] = clamped - low[a];
    // At a voxel centre only that voxel is read: a neighbour that is not finite would spread even with weight 0.
    high[a] = fraction[a] > 0 ? low[a] + 1 : low[a];
  }
  const auto mix = [](double a, double b, double t) { return t > 0 ? (1 - t) * a + t * b : a; };
  return visit_voxel_type(type_, [&]<class T>(std::type_identity<T>) {
    const T* voxels = static_cast<const T*>(data());
    const auto along_i = [&](int j, int k) {
      return mix(static_cast<double>(voxels[offset(low[0], j, k)]), static_cast<double>(voxels[offset(high[0], j, k)]),
                 fraction[0]);
    };
    const auto along_j = [&](int k) { return mix(along_i(low[1], k), along_i(high[1], k), fraction[1]); };
    return mix(along_j(low[2]), along_j(high[2]), fraction[2]);
  });
}

Volume::Range Volume::range() const {
  if (empty()) return {0, 0};
  return visit_voxel_type(type_, [&]<class T>(std::type_identity<T>) { return range_of(voxels<T>()); });
}

}  // namespace simplexseg
