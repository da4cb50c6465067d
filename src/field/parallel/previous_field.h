// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "field/field_prior.h"
#include "field/field_solver.h"
#include "field/parallel/executor.h"
#include "field/parallel/reduce.h"

namespace simplexseg {

inline constexpr float kUnreachedSquare = 1e12f;  ///< mm^2, where there is no voxel on the other side

/// Whether voxels are the object's in the field before.
struct ObjectBefore {
  const std::uint8_t* before;
  const int* voxels;
  std::uint8_t* to;
  SIMPLEXSEG_HD void operator()(int p) const { to[p] = before[voxels[p]] > kPreviousThreshold ? 1 : 0; }
};

/// The least square of the distance from each of several places to a voxel on the other side, as the bits of a float.
struct NearestOther {
  struct Place {
    float x, y, z;  ///< mm, from the box's first voxel
    int voxel;
  };
  const std::uint8_t* before;
  const Place* places;
  int count, size[3];
  float mm[9];   ///< of an index, row by row
  int* bits;     ///< of each place
  int* objects;  ///< of each place: whether it is the object's

  SIMPLEXSEG_HD void operator()(int v) const {
    const float i = static_cast<float>(v % size[0]), j = static_cast<float>(v / size[0] % size[1]),
                k = static_cast<float>(v / (size[0] * size[1]));
    const float x = mm[0] * i + mm[1] * j + mm[2] * k, y = mm[3] * i + mm[4] * j + mm[5] * k,
                z = mm[6] * i + mm[7] * j + mm[8] * k;
    const bool is = before[v] > kPreviousThreshold;
    for (int p = 0; p < count; ++p) {
      const Place& place = places[p];
      if (place.voxel == v) objects[p] = is ? 1 : 0;
      if ((before[place.voxel] > kPreviousThreshold) == is) continue;
      const float dx = x - place.x, dy = y - place.y, dz = z - place.z, square = dx * dx + dy * dy + dz * dz;
      lower(&bits[p], static_cast<int>(bits_of(square)));  // ordered as the floats, which are not negative
    }
  }
};

/// FieldSolver::was_object() of the field before in an executor's memory. Waits once.
template <class Executor>
std::vector<std::uint8_t> was_object(const Executor& executor, const VolumeGeometry& geometry, const VoxelBox& box,
                                     const std::uint8_t* before, std::span<const Eigen::Vector3d> places_mm) {
  std::vector<int> voxels;
  for (const Eigen::Vector3d& mm : places_mm) voxels.push_back(static_cast<int>(nearest_voxel(geometry, box, mm)));
  const auto on_executor = executor.copy_of(std::span<const int>(voxels));
  const auto to = executor.template array<std::uint8_t>(voxels.size());
  executor.each(static_cast<int>(voxels.size()), ObjectBefore{before, on_executor.data(), to.data()});
  std::vector<std::uint8_t> was(voxels.size());
  executor.download(static_cast<const std::uint8_t*>(to.data()), std::span<std::uint8_t>(was));
  return was;
}

/// FieldSolver::before() of the field before in an executor's memory. Waits once.
template <class Executor>
std::vector<FieldSolver::Before> before_at(const Executor& executor, const VolumeGeometry& geometry,
                                           const VoxelBox& box, const std::uint8_t* before,
                                           std::span<const Eigen::Vector3d> places_mm) {
  if (places_mm.empty()) return {};
  const Eigen::Affine3d world = geometry.world_from_index();
  const Eigen::Vector3d first = world * Eigen::Vector3d(box.first[0], box.first[1], box.first[2]);
  std::vector<NearestOther::Place> places;
  for (const Eigen::Vector3d& mm : places_mm) {
    const Eigen::Vector3f from = (mm - first).cast<float>();
    places.push_back({from.x(), from.y(), from.z(), static_cast<int>(nearest_voxel(geometry, box, mm))});
  }
  const std::size_t count = places.size();
  std::vector<int> found(2 * count, static_cast<int>(bits_of(kUnreachedSquare)));
  const auto on_executor = executor.copy_of(std::span<const NearestOther::Place>(places));
  const auto bits = executor.copy_of(std::span<const int>(found));
  NearestOther nearest{before, on_executor.data(), static_cast<int>(count), {box.size[0], box.size[1], box.size[2]},
                       {},     bits.data(),        bits.data() + count};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) nearest.mm[3 * r + c] = static_cast<float>(world.linear()(r, c));
  executor.each(static_cast<int>(box.voxel_count()), nearest);
  executor.download(static_cast<const int*>(bits.data()), std::span<int>(found));
  std::vector<FieldSolver::Before> all;
  for (std::size_t p = 0; p < count; ++p)
    all.push_back({found[count + p] != 0, std::sqrt(float_of(static_cast<unsigned>(found[p])))});
  return all;
}

}  // namespace simplexseg
