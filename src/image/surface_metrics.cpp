// SPDX-License-Identifier: Apache-2.0
#include "image/surface_metrics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/error.h"
#include "image/distance_map.h"
#include "image/metrics.h"

namespace simplexseg {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;

Eigen::Vector3d corner(unsigned c) { return Eigen::Vector3d(c & 1, c >> 1 & 1, c >> 2 & 1); }

/// Index of the cell edge between two corners.
unsigned edge_of(unsigned a, unsigned b) { return std::min(a, b) * 8 + std::max(a, b); }

/// Surface between the inside and the outside corners of a cell, as closed polygons.
std::vector<Polygon> polygons_of(unsigned inside) {
  std::array<std::vector<unsigned>, 64> joined;  // for each cell edge, the cell edges joined to it by a line on a face
  const auto join = [&joined](unsigned a, unsigned b) {
    joined[a].push_back(b);
    joined[b].push_back(a);
  };
  for (unsigned axis = 0; axis < 3; ++axis) {
    const unsigned u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3;
    for (const unsigned base : {0u, 1u << axis}) {
      const std::array<unsigned, 4> ring{base, base | u, base | u | v, base | v};
      std::vector<unsigned> cut;
      for (std::size_t i = 0; i < 4; ++i) {
        const unsigned a = ring[i], b = ring[(i + 1) % 4];
        if ((inside >> a & 1) != (inside >> b & 1)) cut.push_back(edge_of(a, b));
      }
      if (cut.size() == 2) join(cut[0], cut[1]);
      for (std::size_t i = 0; i < 4 && cut.size() == 4; ++i) {
        if (inside >> ring[i] & 1) join(edge_of(ring[(i + 3) % 4], ring[i]), edge_of(ring[i], ring[(i + 1) % 4]));
      }
    }
  }
  std::vector<Polygon> polygons;
  for (unsigned start = 0; start < 64; ++start) {
    if (joined[start].empty()) continue;
    Polygon& polygon = polygons.emplace_back();
    for (unsigned edge = start; !joined[edge].empty();) {
      polygon.push_back((corner(edge / 8) + corner(edge % 8)) / 2);
      const std::vector<unsigned> next = std::exchange(joined[edge], {});
      edge = joined[next[0]].empty() ? next[1] : next[0];
    }
  }
  return polygons;
}

/// Areas, in the unit cell and in mm^2, of the part of a polygon with the corners first ... last. Uses the
/// triangulation with the largest area in the unit cell.
std::pair<double, double> area_of(const Polygon& p, std::size_t first, std::size_t last, const Eigen::Matrix3d& mm) {
  std::pair<double, double> largest{0, 0};
  for (std::size_t k = first + 1; k < last; ++k) {
    const Eigen::Vector3d a = p[k] - p[first], b = p[last] - p[first];
    const auto before = area_of(p, first, k, mm), after = area_of(p, k, last, mm);
    const double unit = 0.5 * a.cross(b).norm() + before.first + after.first;
    if (unit > largest.first + 1e-9)
      largest = {unit, 0.5 * (mm * a).cross(mm * b).norm() + before.second + after.second};
  }
  return largest;
}

/// Bit mask of the inside corners of each cell. Cell (0, 0, 0) starts one voxel before the box along each axis.
std::vector<std::uint8_t> corners_inside(const Mask& mask, const VoxelBox& box, const VoxelBox& cells) {
  const auto [ni, nj, nk] = mask.geometry.size;
  std::vector<std::uint8_t> corners(cells.voxel_count());
  for (int k = 0; k < box.size[2]; ++k) {
    for (int j = 0; j < box.size[1]; ++j) {
      const std::size_t row = (static_cast<std::size_t>(box.first[2] + k) * nj + box.first[1] + j) * ni;
      for (int i = 0; i < box.size[0]; ++i) {
        if (!mask.voxels[row + static_cast<std::size_t>(box.first[0] + i)]) continue;
        for (unsigned c = 0; c < 8; ++c) {  // the voxel is corner c of the cell that starts (x, y, z) before it
          const int x = c & 1, y = c >> 1 & 1, z = c >> 2 & 1;
          corners[cells.offset(i + 1 - x, j + 1 - y, k + 1 - z)] |= static_cast<std::uint8_t>(1u << c);
        }
      }
    }
  }
  return corners;
}

struct Surface {
  std::vector<std::uint8_t> corners, crossed;  ///< per cell: inside corners (bit mask); 1 if the surface crosses it
};

Surface surface_of(const Mask& mask, const VoxelBox& box, const VoxelBox& cells) {
  Surface surface{corners_inside(mask, box, cells), {}};
  surface.crossed.resize(surface.corners.size());
  std::transform(surface.corners.begin(), surface.corners.end(), surface.crossed.begin(),
                 [](std::uint8_t c) { return c != 0 && c != 255; });
  return surface;
}

struct Weighted {
  double max = 0, percentile95 = 0, mean = 0, area = 0, near = 0;  ///< mm, mm^2; near: area within tolerance
};

/// Area-weighted distances from one surface to the other.
Weighted summarise(const Surface& from, const Surface& to, const VoxelBox& cells, const std::array<double, 256>& areas,
                   const Eigen::Matrix3d& mm_from_index, double tolerance_mm) {
  const std::vector<float> map = distance_map(to.crossed, cells, mm_from_index);
  std::vector<std::pair<double, double>> parts;  // distance, area
  for (std::size_t c = 0; c < map.size(); ++c) {
    if (from.crossed[c]) parts.emplace_back(map[c], areas[from.corners[c]]);
  }
  std::sort(parts.begin(), parts.end());
  Weighted result;
  // Float distances contain rounding errors; a distance equal to the tolerance counts as within it.
  const double limit = tolerance_mm * (1 + 1e-6);
  for (const auto& [distance, area] : parts) {
    result.area += area;
    result.mean += distance * area;
    if (distance <= limit) result.near += area;
  }
  result.mean /= result.area;
  result.max = parts.back().first;
  double sum = 0;
  for (const auto& [distance, area] : parts) {
    sum += area;
    result.percentile95 = distance;
    if (sum >= 0.95 * result.area) break;
  }
  return result;
}

}  // namespace

std::array<double, 256> surface_areas(const Eigen::Matrix3d& mm_from_index) {
  std::array<double, 256> areas{};
  for (unsigned code = 1; code < 255; ++code) {
    for (const Polygon& polygon : polygons_of(std::popcount(code) <= 4 ? code : 255 - code))
      areas[code] += area_of(polygon, 0, polygon.size() - 1, mm_from_index).second;
  }
  return areas;
}

SurfaceAgreement compare_surfaces(const Mask& reference, const Mask& test, double tolerance_mm) {
  if (!std::isfinite(tolerance_mm) || tolerance_mm < 0)
    throw Error("tolerance", "it is not a valid length", "enter millimetres, 0 or more");
  require_same_grid(reference, test);
  SurfaceAgreement result{};
  result.tolerance_mm = tolerance_mm;
  const auto is_set = [](std::uint8_t v) { return v != 0; };
  const bool has_reference = std::any_of(reference.voxels.begin(), reference.voxels.end(), is_set),
             has_test = std::any_of(test.voxels.begin(), test.voxels.end(), is_set);
  if (!has_reference && !has_test) {
    result.surface_dice = result.overlap_reference = result.overlap_test = 1;
    return result;
  }
  const VoxelBox box = bounding_box(reference, test);
  const VoxelBox cells{box.first, {box.size[0] + 1, box.size[1] + 1, box.size[2] + 1}};
  const Eigen::Matrix3d mm_from_index = reference.geometry.world_from_index().linear();
  const std::array<double, 256> areas = surface_areas(mm_from_index);
  const Surface a = surface_of(reference, box, cells), b = surface_of(test, box, cells);
  if (!has_reference || !has_test) {
    const auto area_of_all = [&areas](const Surface& s) {
      return std::accumulate(s.corners.begin(), s.corners.end(), 0.0,
                             [&areas](double sum, std::uint8_t c) { return sum + areas[c]; });
    };
    result.area_reference_mm2 = area_of_all(a), result.area_test_mm2 = area_of_all(b);
    result.hd_mm = result.hd95_mm = result.assd_mm = result.asd_reference_mm = result.asd_test_mm = kInfinity;
    return result;
  }
  const Weighted forward = summarise(a, b, cells, areas, mm_from_index, tolerance_mm),
                 backward = summarise(b, a, cells, areas, mm_from_index, tolerance_mm);
  result.hd_mm = std::max(forward.max, backward.max);
  result.hd95_mm = std::max(forward.percentile95, backward.percentile95);
  result.asd_reference_mm = forward.mean, result.asd_test_mm = backward.mean;
  result.assd_mm = 0.5 * (forward.mean + backward.mean);
  result.surface_dice = (forward.near + backward.near) / (forward.area + backward.area);
  result.overlap_reference = forward.near / forward.area, result.overlap_test = backward.near / backward.area;
  result.area_reference_mm2 = forward.area, result.area_test_mm2 = backward.area;
  return result;
}

}  // namespace simplexseg
