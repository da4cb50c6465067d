// SPDX-License-Identifier: Apache-2.0
#include "session/field_voxels.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "forces/step_view.h"
#include "image/distance_map.h"
#include "image/label_surface.h"
#include "image/paint_stroke.h"
#include "image/rasterise.h"
#include "image/voxel_rows.h"

namespace simplexseg {
namespace {

constexpr float kNearVoxels = 2;   // distance from the object up to which the probability is stored, voxels
constexpr int kMargin = 10;        // margin of a field around its object, voxels
constexpr double kMinVoxels = 2;   // smallest radius of the ball of a boundary mark, voxels
constexpr double kMaxVoxels = 60;  // largest distance from a boundary mark at which the surface is searched, voxels

bool is_set(const Mask& mask, const Eigen::Vector3d& index) {
  std::array<int, 3> at;
  for (int a = 0; a < 3; ++a) {
    at[a] = static_cast<int>(std::lround(index[a]));
    if (at[a] < 0 || at[a] >= mask.geometry.size[a]) return false;
  }
  return mask.voxels[(static_cast<std::size_t>(at[2]) * mask.geometry.size[1] + at[1]) * mask.geometry.size[0] + at[0]];
}

void paint_boundary(Mask& mask, const Mark& mark) {
  const Eigen::Affine3d index = mask.geometry.index_from_world();
  const double voxel_mm = mask.geometry.spacing_mm.minCoeff();
  const bool inside = is_set(mask, index * mark.position_mm);
  const Eigen::Vector3d outward = mark.outward.normalized(), direction = inside ? outward : Eigen::Vector3d(-outward);
  double distance_mm = 0;
  while (distance_mm < kMaxVoxels * voxel_mm &&
         is_set(mask, index * (mark.position_mm + distance_mm * direction)) == inside)
    distance_mm += 0.5 * voxel_mm;
  if (distance_mm >= kMaxVoxels * voxel_mm) distance_mm = 0;  // no surface in that direction
  const double radius_mm = std::max(distance_mm, kMinVoxels * voxel_mm);
  apply({!inside, {mark.position_mm + radius_mm * direction}, radius_mm}, mask);
}

}  // namespace

FieldValue field_value_of(const VolumeGeometry& geometry) {
  const float voxel_mm = static_cast<float>(geometry.spacing_mm.minCoeff());
  return {kFieldScale, kFieldFloor, kFieldFall / voxel_mm, kThresholdMargin * kFieldScale, kNearVoxels * voxel_mm};
}

MeshField field_of_start(const SimplexMesh& start, std::vector<Mark> marks, const std::vector<Mark>& others,
                         const VolumeGeometry& geometry, const RunJobs& run) {
  Mask mask = rasterise(start, geometry);
  for (const Mark& other : others) apply({false, {other.position_mm}, other.radius_mm}, mask);
  for (std::size_t m = 1; m < marks.size(); ++m) {  // the first mark is the seed, which `start` replaces
    const Mark& mark = marks[m];
    if (mark.kind == MarkKind::Boundary)
      paint_boundary(mask, mark);
    else
      apply({mark.kind == MarkKind::Inside, {mark.position_mm}, mark.radius_mm}, mask);
  }
  MeshField field;
  field.box = bounding_box(mask, mask);
  if (field.box.voxel_count() == 0)
    throw Error("the segmentation from labels", "it contains no voxel of the image",
                "use labels of this image, or remove the marks that exclude all of it");
  for (int a = 0; a < 3; ++a) {
    const int first = std::max(0, field.box.first[a] - kMargin);
    const int end = std::min(geometry.size[a], field.box.first[a] + field.box.size[a] + kMargin);
    field.box.first[a] = first, field.box.size[a] = end - first;
  }
  std::vector<std::uint8_t> object(field.box.voxel_count());
  copy_from_outer(mask.voxels.data(), VoxelBox{{0, 0, 0}, geometry.size}, object.data(), field.box);
  std::vector<float> share = smoothed_voxels(object, field.box);
  for (float& p : share) p = std::clamp(p, 0.0f, 1.0f);
  field.values = field_values(object, share, field.box, geometry, field_value_of(geometry), run);
  field.marks = std::move(marks);
  return field;
}

}  // namespace simplexseg
