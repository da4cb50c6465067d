// SPDX-License-Identifier: Apache-2.0
#include "field/robot_user.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "field/box_prompt.h"
#include "field/lasso_prompt.h"
#include "field/robot_stroke.h"
#include "field/stroke.h"
#include "image/distance_map.h"

namespace simplexseg {
namespace {

struct Part {
  std::vector<std::size_t> voxels;
  std::array<int, 3> low, high;
};

/// Largest 6-connected component of the voxels for which wanted(v).
template <class Wanted>
Part largest(const VolumeGeometry& geometry, Wanted&& wanted) {
  const auto [ni, nj, nk] = geometry.size;
  std::vector<std::uint8_t> seen(geometry.voxel_count());
  Part best, part;
  for (std::size_t start = 0; start < seen.size(); ++start) {
    if (seen[start] || !wanted(start)) continue;
    part.voxels.assign(1, start);
    part.low = {ni, nj, nk};
    part.high = {-1, -1, -1};
    seen[start] = 1;
    for (std::size_t next = 0; next < part.voxels.size(); ++next) {
      const std::size_t v = part.voxels[next];
      const int i = static_cast<int>(v % ni), j = static_cast<int>(v / ni % nj), k = static_cast<int>(v / ni / nj);
      const std::array<int, 3> at{i, j, k}, size{ni, nj, nk};
      const std::array<std::size_t, 3> stride{1, std::size_t(ni), std::size_t(ni) * nj};
      for (int a = 0; a < 3; ++a) {
        part.low[a] = std::min(part.low[a], at[a]);
        part.high[a] = std::max(part.high[a], at[a]);
        for (const int step : {-1, 1}) {
          if (at[a] + step < 0 || at[a] + step == size[a]) continue;
          const std::size_t neighbour = step < 0 ? v - stride[a] : v + stride[a];
          if (seen[neighbour] || !wanted(neighbour)) continue;
          seen[neighbour] = 1;
          part.voxels.push_back(neighbour);
        }
      }
    }
    if (part.voxels.size() > best.voxels.size()) std::swap(best, part);
  }
  return best;
}

WorstError deepest_of(const VolumeGeometry& geometry, Part part, bool too_little) {
  const auto [ni, nj, nk] = geometry.size;
  VoxelBox box;
  for (int a = 0; a < 3; ++a) {
    box.first[a] = std::max(0, part.low[a] - 1);
    box.size[a] = std::min(geometry.size[a] - 1, part.high[a] + 1) - box.first[a] + 1;
  }
  std::vector<std::uint8_t> other(box.voxel_count(), 1);
  std::sort(part.voxels.begin(), part.voxels.end());
  const auto in_box = [&, ni = ni, nj = nj](std::size_t v) {
    return box.offset(static_cast<int>(v % ni) - box.first[0], static_cast<int>(v / ni % nj) - box.first[1],
                      static_cast<int>(v / ni / nj) - box.first[2]);
  };
  for (const std::size_t v : part.voxels) other[in_box(v)] = 0;
  const std::vector<float> depth = distance_map(other, box, geometry.world_from_index().linear());
  std::size_t best = part.voxels.front();
  for (const std::size_t v : part.voxels)
    if (depth[in_box(v)] > depth[in_box(best)]) best = v;
  return {{static_cast<int>(best % ni), static_cast<int>(best / ni % nj), static_cast<int>(best / ni / nj)},
          depth[in_box(best)],
          part.voxels.size(),
          too_little};
}

constexpr double kNearVoxels = 2.5;

/// Nearest point (mm) to a place of those halfway between a voxel of the mask and a neighbour that is not, or the end
/// of the grid; the place itself for an empty mask.
Eigen::Vector3d boundary_near(const Mask& mask, const Eigen::Vector3d& from) {
  const VolumeGeometry& g = mask.geometry;
  const Eigen::Affine3d world = g.world_from_index();
  Eigen::Vector3d best = from;
  double square = std::numeric_limits<double>::infinity();
  std::size_t v = 0;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i, ++v) {
        if (!mask.voxels[v]) continue;
        const std::array<int, 3> at{i, j, k};
        const std::array<std::size_t, 3> stride{1, std::size_t(g.size[0]), std::size_t(g.size[0]) * g.size[1]};
        for (int side = 0; side < 6; ++side) {
          const int a = side / 2, step = side % 2 ? 1 : -1, to = at[a] + step;
          const bool last = to < 0 || to == g.size[a];
          if (!last && mask.voxels[step > 0 ? v + stride[a] : v - stride[a]]) continue;
          Eigen::Vector3d half(i, j, k);
          half[a] += 0.5 * step;
          const double d = (world * half - from).squaredNorm();
          if (d < square) square = d, best = world * half;
        }
      }
  return best;
}

}  // namespace

std::optional<WorstError> worst_error(const Mask& truth, const Mask& now) {
  if (!truth.geometry.same_grid(now.geometry))
    throw Error("the robot cannot compare", "reference and result have different grids", "resample one onto the other");
  const std::uint8_t *const t = truth.voxels.data(), *const n = now.voxels.data();
  Part missing = largest(truth.geometry, [=](std::size_t v) { return t[v] && !n[v]; });
  Part extra = largest(truth.geometry, [=](std::size_t v) { return !t[v] && n[v]; });
  if (missing.voxels.empty() && extra.voxels.empty()) return std::nullopt;
  const bool too_little = missing.voxels.size() >= extra.voxels.size();
  return deepest_of(truth.geometry, std::move(too_little ? missing : extra), too_little);
}

std::optional<WorstError> deepest_voxel(const Mask& mask) {
  Part part = largest(mask.geometry, [m = mask.voxels.data()](std::size_t v) { return m[v] != 0; });
  if (part.voxels.empty()) return std::nullopt;
  return deepest_of(mask.geometry, std::move(part), true);
}

Mask largest_part(const Mask& mask) {
  Mask part{mask.geometry, std::vector<std::uint8_t>(mask.voxels.size())};
  for (const std::size_t v :
       largest(mask.geometry, [m = mask.voxels.data()](std::size_t w) { return m[w] != 0; }).voxels)
    part.voxels[v] = 1;
  return part;
}

ClickReach reach_of_click(const Mask& before, const Mask& after, const std::array<int, 3>& voxel, double depth_mm,
                          std::size_t truth_voxels) {
  const VolumeGeometry& g = after.geometry;
  if (!g.same_grid(before.geometry))
    throw Error("the robot cannot compare", "two results have different grids", "resample one onto the other");
  const Eigen::Matrix3d mm = g.world_from_index().linear();
  const double far_square = kFarDepths * kFarDepths * depth_mm * depth_mm;
  double farthest_square = 0;
  std::size_t far = 0, v = 0;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i, ++v) {
        if ((before.voxels[v] != 0) == (after.voxels[v] != 0)) continue;
        const double square = (mm * Eigen::Vector3d(i - voxel[0], j - voxel[1], k - voxel[2])).squaredNorm();
        farthest_square = std::max(farthest_square, square);
        if (square > far_square) ++far;
      }
  return {depth_mm, static_cast<double>(far) / static_cast<double>(truth_voxels), std::sqrt(farthest_square)};
}

std::vector<RobotClick> run_robot(const Mask& truth, RobotSubject& subject, const RobotSettings& settings,
                                  const std::function<void(int, const Mask&)>& after_click) {
  const Mask part = largest_part(truth);
  const std::optional<WorstError> deepest = deepest_voxel(part);
  const auto truth_voxels = static_cast<std::size_t>(std::ranges::count(part.voxels, std::uint8_t{1}));
  if (!deepest) throw Error("the robot has no reference", "no voxel has the label", "give a label that occurs");
  const Eigen::Affine3d world = truth.geometry.world_from_index();
  const auto place = [&](const std::array<int, 3>& voxel) -> Eigen::Vector3d {
    return world * Eigen::Vector3d(voxel[0], voxel[1], voxel[2]);
  };
  // Excludes the voxels at exactly that distance, which are outside.
  const double radius_mm = 0.999 * deepest->depth_mm;
  std::vector<Mark> marks{
      {MarkKind::Inside,
       place(deepest->voxel) + Eigen::Vector3d::Ones().normalized() * settings.seed_offset * radius_mm,
       settings.seed_scale * radius_mm,
       {0, 0, 0}}};
  if (settings.starts_with_box) marks = prompt_of_box(box_around_object(part, *deepest), truth.geometry).marks();
  if (settings.starts_with_lasso) {
    if (const std::optional<RobotLasso> lasso =
            lasso_at_error(part, Mask{truth.geometry, std::vector<std::uint8_t>(part.voxels.size())}, *deepest, 0)) {
      marks = {seed_of_lasso(lasso->contour_mm, lasso->normal, truth.geometry)};
      const std::vector<Mark> around = marks_of_strokes(
          prompt_of_lasso(MarkKind::Inside, lasso->contour_mm, lasso->normal, truth.geometry, true), MarkLink::Update);
      marks.insert(marks.end(), around.begin(), around.end());
    }
  }
  const std::size_t start_count = marks.size();
  std::vector<RobotClick> clicks;
  std::optional<WorstError> error;  // corrected by the last mark
  Mask before;
  for (int click = 0;; ++click) {
    for (std::size_t m = start_count; m < marks.size(); ++m) marks[m].local = settings.local;
    const auto start = std::chrono::steady_clock::now();
    Mask now = subject.segment(marks);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    clicks.push_back({marks.back(), compare(part, now), seconds, {}});
    if (error) clicks.back().reach = reach_of_click(before, now, error->voxel, error->depth_mm, truth_voxels);
    after_click(click, now);
    if (click == settings.most_clicks) break;
    error = worst_error(part, now);
    if (!error) break;
    const Eigen::Vector3d at = place(error->voxel);
    before = std::move(now);
    RobotClickKind kind_of_click = settings.click_kind;
    Eigen::Vector3d surface = at;  // nearest point of the surface
    const bool of_surface = kind_of_click == RobotClickKind::Points || kind_of_click == RobotClickKind::Grabs ||
                            kind_of_click == RobotClickKind::Mixed;
    if (of_surface) surface = boundary_near(before, at);
    if (kind_of_click == RobotClickKind::Mixed) {
      const double near_mm = kNearVoxels * truth.geometry.spacing_mm.minCoeff();
      const double distance_mm = (surface - at).norm();  // 0 without a surface
      kind_of_click = distance_mm > 0 && distance_mm < near_mm ? RobotClickKind::Grabs : RobotClickKind::Marks;
    }
    const MarkKind kind = error->too_little ? MarkKind::Inside : MarkKind::Outside;
    if (kind_of_click == RobotClickKind::Lassos) {
      if (const std::optional<RobotLasso> lasso = lasso_at_error(part, before, *error, click + 1)) {
        try {
          const std::vector<Mark> added =
              marks_of_strokes(prompt_of_lasso(lasso->kind, lasso->contour_mm, lasso->normal, truth.geometry));
          marks.insert(marks.end(), added.begin(), added.end());
          continue;
        } catch (const Error&) {  // too thin for a lasso
        }
      }
      kind_of_click = RobotClickKind::Marks;
    }
    if (kind_of_click == RobotClickKind::Strokes) {
      const std::vector<Eigen::Vector3d> path = stroke_in_error(part, before, *error, click + 1);
      double radius_mm = subject.brush_mm(kind, path.front());
      for (const Eigen::Vector3d& mm : path) radius_mm = std::min(radius_mm, subject.brush_mm(kind, mm));
      const std::vector<Mark> stroke = marks_of_stroke(kind, path, radius_mm);
      marks.insert(marks.end(), stroke.begin(), stroke.end());
      continue;
    }
    if (kind_of_click != RobotClickKind::Marks) {
      const Eigen::Vector3d to = boundary_near(part, at);
      const Eigen::Vector3d drag = to - surface;
      const double sign = error->too_little ? 1 : -1;
      marks.push_back(
          {MarkKind::Boundary, to, truth.geometry.spacing_mm.minCoeff(),
           kind_of_click == RobotClickKind::Grabs ? Eigen::Vector3d(sign * drag) : Eigen::Vector3d::Zero()});
      continue;
    }
    marks.push_back({kind, at, subject.brush_mm(kind, at), {0, 0, 0}});
  }
  return clicks;
}

}  // namespace simplexseg
