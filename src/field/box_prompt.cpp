// SPDX-License-Identifier: Apache-2.0
#include "field/box_prompt.h"

#include <algorithm>

#include "core/error.h"
#include "image/volume.h"

namespace simplexseg {
namespace {

constexpr double kSeedShare = 0.35;   // radius of the seed, relative to half of the shorter side
constexpr double kLeastStroke = 0.5;  // shortest stroke along the longer side, relative to twice its radius
constexpr double kOutsideVoxels = 5;  // distance of the outside strokes from the box, voxels

/// Last place in the volume on the way from a place in it to another place.
Eigen::Vector3d last_inside(const VolumeGeometry& volume, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d start = volume.index_from_world() * from, along = volume.index_from_world() * to - start;
  constexpr double kToFace = 0.49;  // from the centre of an outer voxel to the face of the volume, voxels
  double share = 1;
  for (int a = 0; a < 3; ++a) {
    const double room = along[a] > 0 ? volume.size[a] - 1.0 + kToFace - start[a] : kToFace + start[a];
    if (std::abs(along[a]) > 1e-9) share = std::min(share, std::max(room, 0.0) / std::abs(along[a]));
  }
  return share == 1 ? to : from + share * (to - from);
}

}  // namespace

BoxPrompt prompt_of_box(const BoxCorners& corners, const VolumeGeometry& volume) {
  const Eigen::Vector3d centre = (corners[0] + corners[2]) / 2;
  const Eigen::Vector3d u = (corners[1] - corners[0]) / 2, v = (corners[3] - corners[0]) / 2;
  const double voxel_mm = volume.spacing_mm.minCoeff(), shorter_mm = std::min(u.norm(), v.norm());
  if (!(shorter_mm > 0) || !centre.allFinite())
    throw Error("the box", "a side has no length or is not a number", "draw a rectangle around the structure");
  if (!volume.contains(centre))
    throw Error("the box", "its centre lies outside the image", "draw it around a structure in the image");
  BoxPrompt prompt;
  const double radius_mm = std::max(kSeedShare * shorter_mm, voxel_mm);
  prompt.seed = {MarkKind::Inside, centre, radius_mm};
  const Eigen::Vector3d& longer = u.norm() > v.norm() ? u : v;
  const double reach_mm = kSeedShare * (longer.norm() - shorter_mm);
  if (reach_mm > kLeastStroke * radius_mm) {
    const Eigen::Vector3d along = reach_mm * longer.normalized();
    prompt.strokes.push_back(
        {MarkKind::Inside,
         {last_inside(volume, centre, centre - along), last_inside(volume, centre, centre + along)},
         radius_mm});
  }
  // Very large boxes have thicker strokes, which then have at most 1,600 balls.
  const double outside_radius_mm = std::clamp((u.norm() + v.norm()) / 400, voxel_mm, 3 * voxel_mm);
  BoxCorners around;
  const double distance_mm = kOutsideVoxels * voxel_mm;
  for (int c = 0; c < 4; ++c) {
    const double along_u = c == 1 || c == 2 ? 1 : -1, along_v = c >= 2 ? 1 : -1;
    around[c] = centre + along_u * (u + distance_mm * u.normalized()) + along_v * (v + distance_mm * v.normalized());
  }
  bool in_stroke = false;  // whether the side before this one has a stroke
  for (int side = 0; side < 4; ++side) {
    const Eigen::Vector3d &from = around[side], &to = around[(side + 1) % 4];
    const Eigen::Vector3d middle = (from + to) / 2;
    if (!volume.contains(middle)) {
      in_stroke = false;
      continue;
    }
    const Eigen::Vector3d begin = last_inside(volume, middle, from), end = last_inside(volume, middle, to);
    if (!in_stroke || begin != from) prompt.strokes.push_back({MarkKind::Outside, {begin}, outside_radius_mm});
    prompt.strokes.back().path_mm.push_back(end);
    in_stroke = end == to;
  }
  return prompt;
}

std::vector<Mark> BoxPrompt::marks() const {
  std::vector<Mark> all{seed};
  const std::vector<Mark> others = marks_of_strokes(strokes, MarkLink::Update);
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

}  // namespace simplexseg
