// SPDX-License-Identifier: Apache-2.0
#include "gui/look/slice_geometry.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {

const char* title_of(Orientation orientation) {
  switch (orientation) {
    case Orientation::Axial:
      return "Axial";
    case Orientation::Sagittal:
      return "Sagittal";
    case Orientation::Coronal:
      break;
  }
  return "Coronal";
}

SliceAxes slice_axes(Orientation orientation, Convention convention) {
  const double left = convention == Convention::Radiological ? 1 : -1;
  switch (orientation) {
    case Orientation::Axial:
      return {2, {left, 0, 0}, {0, -1, 0}};
    case Orientation::Sagittal:
      return {0, {0, 1, 0}, {0, 0, 1}};
    case Orientation::Coronal:
      break;
  }
  return {1, {left, 0, 0}, {0, 0, 1}};
}

char letter_of(const Eigen::Vector3d& direction) {
  SIMPLEXSEG_EXPECT(!direction.isZero());
  int axis;
  direction.cwiseAbs().maxCoeff(&axis);
  return "RLAPIS"[2 * axis + (direction[axis] > 0)];
}

WorldBox world_box(const VolumeGeometry& geometry) {
  const Eigen::Affine3d world_from_index = geometry.world_from_index();
  WorldBox box{Eigen::Vector3d::Constant(INFINITY), Eigen::Vector3d::Constant(-INFINITY)};
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int axis = 0; axis < 3; ++axis) index[axis] = (corner >> axis & 1) ? geometry.size[axis] - 0.5 : -0.5;
    const Eigen::Vector3d world = world_from_index * index;
    box.low_mm = box.low_mm.cwiseMin(world);
    box.high_mm = box.high_mm.cwiseMax(world);
  }
  return box;
}

namespace {
// Returns the voxel axis nearest to a world axis.
int nearest_voxel_axis(const VolumeGeometry& geometry, int world_axis) {
  int best;
  geometry.direction.row(world_axis).cwiseAbs().maxCoeff(&best);
  return best;
}
}  // namespace

bool is_axis_aligned(const VolumeGeometry& geometry) {
  std::array<bool, 3> taken{};
  for (int world_axis = 0; world_axis < 3; ++world_axis) {
    const int voxel_axis = nearest_voxel_axis(geometry, world_axis);
    if (taken[voxel_axis]) return false;
    taken[voxel_axis] = true;
    Eigen::Vector3d rest = geometry.direction.col(voxel_axis);
    rest[world_axis] = 0;
    // The end of the axis must deviate by at most a tenth of a voxel.
    const double drift = rest.norm() * geometry.spacing_mm[voxel_axis] * geometry.size[voxel_axis];
    if (drift > 0.1 * geometry.spacing_mm.minCoeff()) return false;
  }
  return true;
}

Eigen::Vector3d slice_spacing_mm(const VolumeGeometry& geometry) {
  Eigen::Vector3d spacing;
  for (int axis = 0; axis < 3; ++axis) spacing[axis] = geometry.spacing_mm[nearest_voxel_axis(geometry, axis)];
  return spacing;
}

SliceNumber slice_number(const VolumeGeometry& geometry, Orientation orientation, const Eigen::Vector3d& at_mm) {
  const int normal = slice_axes(orientation, Convention::Radiological).normal;
  const WorldBox box = world_box(geometry);
  const double spacing_mm = slice_spacing_mm(geometry)[normal];
  const int count = std::max(1, static_cast<int>(std::lround(box.extent_mm()[normal] / spacing_mm)));
  const double along = (at_mm[normal] - box.low_mm[normal]) / spacing_mm;
  return {std::clamp(static_cast<int>(std::floor(along)) + 1, 1, count), count, spacing_mm};
}

Eigen::Vector3d snap_to_voxel(const VolumeGeometry& geometry, const Eigen::Vector3d& world_mm) {
  if (!is_axis_aligned(geometry)) {
    const WorldBox box = world_box(geometry);
    return world_mm.cwiseMax(box.low_mm).cwiseMin(box.high_mm);
  }
  Eigen::Vector3d index = geometry.index_from_world() * world_mm;
  for (int axis = 0; axis < 3; ++axis)
    index[axis] = std::clamp(std::round(index[axis]), 0.0, geometry.size[axis] - 1.0);
  return geometry.world_from_index() * index;
}

int texels_per_voxel(const VolumeGeometry& geometry) {
  constexpr int kLarge = 256;
  return *std::max_element(geometry.size.begin(), geometry.size.end()) <= kLarge ? 3 : 1;
}

SliceGrid slice_grid(const VolumeGeometry& geometry, Orientation orientation, const Eigen::Vector3d& through_mm,
                     int texels_per_voxel) {
  SIMPLEXSEG_EXPECT(texels_per_voxel >= 1);
  constexpr double kMaxTexels = 2048;
  const WorldBox box = world_box(geometry);
  const Eigen::Vector3d spacing = slice_spacing_mm(geometry), extent = box.extent_mm();
  const int normal = slice_axes(orientation, Convention::Radiological).normal;
  const int u = normal == 0 ? 1 : 0, v = normal == 2 ? 1 : 2;
  const auto texels = [&](int axis) {
    return static_cast<int>(std::clamp(texels_per_voxel * std::round(extent[axis] / spacing[axis]), 1.0, kMaxTexels));
  };
  SliceGrid grid;
  grid.width = texels(u);
  grid.height = texels(v);
  grid.step_u_mm = Eigen::Vector3d::Unit(u) * (extent[u] / grid.width);
  grid.step_v_mm = Eigen::Vector3d::Unit(v) * (extent[v] / grid.height);
  grid.origin_mm = box.low_mm + 0.5 * (grid.step_u_mm + grid.step_v_mm);
  grid.origin_mm[normal] = through_mm[normal];
  return grid;
}

int position_decimals(const VolumeGeometry& geometry) {
  constexpr double kUsualMm = 0.1;  // one decimal suffices from this spacing on
  const double finest_mm = geometry.spacing_mm.minCoeff();
  if (!(finest_mm > 0) || finest_mm >= kUsualMm) return 1;
  return std::clamp(1 + static_cast<int>(std::ceil(-std::log10(finest_mm))), 1, 6);
}

SlicePlane slice_plane(const VolumeGeometry& geometry, const SliceGrid& grid, double window, double level) {
  SIMPLEXSEG_EXPECT(window > 0);
  const Eigen::Affine3d index_from_world = geometry.index_from_world();
  // Rounding errors must neither blend in the next voxel nor move the outermost texels outside.
  constexpr double kOnCentre = 1e-3;  // tolerance at the last texel, voxels
  const auto snapped = [](const Eigen::Vector3d& v, int count) {
    float component[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double whole = std::round(v[axis]);
      component[axis] = static_cast<float>(std::abs(v[axis] - whole) * count < kOnCentre ? whole : v[axis]);
    }
    return Vec3{component[0], component[1], component[2]};
  };
  SlicePlane plane;
  plane.origin = snapped(index_from_world * grid.origin_mm, 1);
  plane.step_u = snapped(index_from_world.linear() * grid.step_u_mm, grid.width);
  plane.step_v = snapped(index_from_world.linear() * grid.step_v_mm, grid.height);
  plane.width = grid.width;
  plane.height = grid.height;
  plane.low = static_cast<float>(level - window / 2);
  plane.high = static_cast<float>(level + window / 2);
  return plane;
}

}  // namespace simplexseg
