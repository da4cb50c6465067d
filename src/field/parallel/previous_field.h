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

inline constexpr float kUnreachedSquare = 1e12f;  ///< squared distance without a voxel on the other side, mm^2

/// Smallest squared distance from each of several places to a voxel on the other side of the previous surface.
struct NearestOther {
  struct Place {
    float x, y, z;  ///< mm, from the first voxel of the box
    int voxel;      ///< nearest voxel of the box
  };
  const std::uint8_t* previous;
  const Place* places;
  int count, size[3];
  float mm[9];   ///< from indices to mm, row by row
  int* bits;     ///< for each place the squared distance, as the bits of a float
  int* objects;  ///< for each place whether it is in the object

  SIMPLEXSEG_HD void operator()(int v) const {
    const float i = static_cast<float>(v % size[0]), j = static_cast<float>(v / size[0] % size[1]),
                k = static_cast<float>(v / (size[0] * size[1]));
    const float x = mm[0] * i + mm[1] * j + mm[2] * k, y = mm[3] * i + mm[4] * j + mm[5] * k,
                z = mm[6] * i + mm[7] * j + mm[8] * k;
    const bool in_object = previous[v] > kPreviousThreshold;
    for (int p = 0; p < count; ++p) {
      const Place& place = places[p];
      if (place.voxel == v) objects[p] = in_object ? 1 : 0;
      if ((previous[place.voxel] > kPreviousThreshold) == in_object) continue;
      const float dx = x - place.x, dy = y - place.y, dz = z - place.z, square = dx * dx + dy * dy + dz * dz;
      lower(&bits[p], static_cast<int>(bits_of(square)));  // bits of floats >= 0 have the order of the floats
    }
  }
};

/// FieldSolver::previous_object() with the previous field in the memory of an executor. Waits once.
template <class Executor>
std::vector<std::uint8_t> previous_object(const Executor& executor, const VolumeGeometry& geometry, const VoxelBox& box,
                                          const std::uint8_t* previous, std::span<const Eigen::Vector3d> places_mm) {
  std::vector<int> voxels;
  for (const Eigen::Vector3d& mm : places_mm) voxels.push_back(static_cast<int>(nearest_voxel(geometry, box, mm)));
  const auto on_executor = executor.copy_of(std::span<const int>(voxels));
  const auto objects = executor.template array<std::uint8_t>(voxels.size());
  const int* const at = on_executor.data();
  std::uint8_t* const to = objects.data();
  executor.each(static_cast<int>(voxels.size()),
                [=] SIMPLEXSEG_KERNEL(int p) { to[p] = previous[at[p]] > kPreviousThreshold ? 1 : 0; });
  std::vector<std::uint8_t> in_object(voxels.size());
  executor.download(static_cast<const std::uint8_t*>(to), std::span<std::uint8_t>(in_object));
  return in_object;
}

/// FieldSolver::previous_sides() with the previous field in the memory of an executor. Waits once.
template <class Executor>
std::vector<FieldSolver::PreviousSide> previous_sides(const Executor& executor, const VolumeGeometry& geometry,
                                                      const VoxelBox& box, const std::uint8_t* previous,
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
  NearestOther nearest{previous, on_executor.data(), static_cast<int>(count), {box.size[0], box.size[1], box.size[2]},
                       {},       bits.data(),        bits.data() + count};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) nearest.mm[3 * r + c] = static_cast<float>(world.linear()(r, c));
  executor.each(static_cast<int>(box.voxel_count()), nearest);
  executor.download(static_cast<const int*>(bits.data()), std::span<int>(found));
  std::vector<FieldSolver::PreviousSide> all;
  for (std::size_t p = 0; p < count; ++p)
    all.push_back({found[count + p] != 0, std::sqrt(float_of(static_cast<unsigned>(found[p])))});
  return all;
}

}  // namespace simplexseg
