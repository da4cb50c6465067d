// SPDX-License-Identifier: Apache-2.0
#include "serve/drawn_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <string>
#include <utility>

#include "core/error.h"
#include "field/slice_region.h"
#include "image/paint_voxels.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMinBranch = 4;       // voxels of a branch beside the longest path of a scribble
constexpr std::size_t kMinArea = 9;         // voxels of an area beside larger ones of a lasso
constexpr double kLineShare = 0.25;         // least enclosed area of a closed line, relative to the voxels of the line
constexpr std::size_t kMaxVertices = 5000;  // largest number in a contour

VoxelBox set_box(const Mask& mask) {
  const VoxelBox box = bounding_box(mask, mask);
  if (box.voxel_count() == 0) throw Error("the drawn mask", "it has no set voxel", "draw in the image");
  return box;
}

/// Axis along which a box has the fewest voxels; the last of equal ones.
int thinnest_axis(const VoxelBox& box) {
  int axis = 2;
  for (int a = 1; a >= 0; --a)
    if (box.size[a] < box.size[axis]) axis = a;
  return axis;
}

/// Index of a voxel of a box from the number of its slice along `axis`, and its place in the slice.
std::array<int, 3> in_slice(int axis, int slice, int a, int b) {
  std::array<int, 3> index{};
  index[axis] = slice, index[axis == 0 ? 1 : 0] = a, index[axis == 2 ? 1 : 2] = b;
  return index;
}

/// Voxels of one slice of a mask within its box.
struct Slice {
  int size_a, size_b;
  std::vector<std::uint8_t> set;
  std::size_t at(int a, int b) const { return static_cast<std::size_t>(b) * size_a + a; }
  bool contains(int a, int b) const { return a >= 0 && b >= 0 && a < size_a && b < size_b; }
};

/// Marks each unset voxel that is not connected with the border of the slice across faces.
std::vector<std::uint8_t> enclosed_voxels(const Slice& slice) {
  std::vector<std::uint8_t> enclosed(slice.set.size());
  std::ranges::transform(slice.set, enclosed.begin(), [](std::uint8_t set) { return set == 0; });
  std::vector<std::array<int, 2>> open;
  const auto visit = [&](int a, int b) {
    if (slice.contains(a, b) && std::exchange(enclosed[slice.at(a, b)], 0) != 0) open.push_back({a, b});
  };
  for (int a = 0; a < slice.size_a; ++a) visit(a, 0), visit(a, slice.size_b - 1);
  for (int b = 0; b < slice.size_b; ++b) visit(0, b), visit(slice.size_a - 1, b);
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    visit(a - 1, b), visit(a + 1, b), visit(a, b - 1), visit(a, b + 1);
  }
  return enclosed;
}

/// Replaces a closed line by the area within its middle, and fills holes of an area.
void fill(Slice& slice) {
  const std::vector<std::uint8_t> enclosed = enclosed_voxels(slice);
  const auto inner = std::ranges::count(enclosed, 1), drawn = std::ranges::count(slice.set, 1);
  if (inner == 0) return;
  const bool is_line = static_cast<double>(inner) >= kLineShare * static_cast<double>(drawn);
  if (!is_line) {
    for (std::size_t v = 0; v < slice.set.size(); ++v) slice.set[v] |= enclosed[v];
    return;
  }
  // Each voxel of the line belongs to the side that reaches it first; equally far ones, to the inside.
  enum Side : std::uint8_t { kInside = 1, kOutside = 2 };
  std::vector<std::uint8_t> side(slice.set.size());
  std::queue<std::array<int, 2>> open;
  for (const Side wanted : {kInside, kOutside})
    for (int b = 0; b < slice.size_b; ++b)
      for (int a = 0; a < slice.size_a; ++a) {
        const std::size_t v = slice.at(a, b);
        if (slice.set[v] != 0 || (enclosed[v] != 0) != (wanted == kInside)) continue;
        side[v] = wanted;
        open.push({a, b});
      }
  while (!open.empty()) {
    const auto [a, b] = open.front();
    open.pop();
    for (const auto& [da, db] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (!slice.contains(a + da, b + db) || side[slice.at(a + da, b + db)] != 0) continue;
      side[slice.at(a + da, b + db)] = side[slice.at(a, b)];
      open.push({a + da, b + db});
    }
  }
  for (std::size_t v = 0; v < side.size(); ++v) slice.set[v] = side[v] == kInside;
}

Mask cropped(const Mask& mask, const VoxelBox& box) {
  Mask part{grid_of_box(mask.geometry, box), {}};
  part.voxels.reserve(box.voxel_count());
  const VoxelBox all{{0, 0, 0}, mask.geometry.size};
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i)
        part.voxels.push_back(mask.voxels[all.offset(i + box.first[0], j + box.first[1], k + box.first[2])]);
  return part;
}

/// Calls `use(region)` for each connected region of each slice; `use` may clear voxels of `part`, and the rest of the
/// region is visited again. The voxels of a region are cleared if `use` returns true.
template <class Use>
void for_each_region(Mask& part, int axis, const Use& use) {
  const VoxelBox all{{0, 0, 0}, part.geometry.size};
  const int size_a = all.size[axis == 0 ? 1 : 0], size_b = all.size[axis == 2 ? 1 : 2];
  for (int slice = 0; slice < all.size[axis]; ++slice)
    for (int b = 0; b < size_b; ++b)
      for (int a = 0; a < size_a; ++a) {
        const std::array<int, 3> index = in_slice(axis, slice, a, b);
        const std::size_t start = all.offset(index[0], index[1], index[2]);
        while (part.voxels[start] != 0) {
          SliceRegion region(part.geometry, index, axis, [&](std::size_t v) { return part.voxels[v] != 0; });
          if (use(region))
            for (const std::size_t v : region.voxels()) part.voxels[v] = 0;
        }
      }
}

/// Sets a voxel between each two of a slice that share a corner alone, so that thin lines are connected across faces.
void join_corners(Mask& part, int axis) {
  const VoxelBox all{{0, 0, 0}, part.geometry.size};
  const int size_a = all.size[axis == 0 ? 1 : 0], size_b = all.size[axis == 2 ? 1 : 2];
  for (int slice = 0; slice < all.size[axis]; ++slice)
    for (int b = 0; b + 1 < size_b; ++b)
      for (int a = 0; a + 1 < size_a; ++a) {
        const auto voxel = [&](int da, int db) -> std::uint8_t& {
          const std::array<int, 3> index = in_slice(axis, slice, a + da, b + db);
          return part.voxels[all.offset(index[0], index[1], index[2])];
        };
        const bool rises = voxel(0, 0) && voxel(1, 1) && !voxel(1, 0) && !voxel(0, 1);
        const bool falls = voxel(1, 0) && voxel(0, 1) && !voxel(0, 0) && !voxel(1, 1);
        if (rises) voxel(1, 0) = 1;
        if (falls) voxel(0, 0) = 1;
      }
}

/// Whether a neighbour of a voxel in its slice is set.
bool touches(const std::vector<std::uint8_t>& set, const VoxelBox& all, std::size_t voxel, int axis) {
  const auto row = static_cast<std::size_t>(all.size[0]), area = row * static_cast<std::size_t>(all.size[1]);
  const std::array<int, 3> at{static_cast<int>(voxel % row), static_cast<int>(voxel % area / row),
                              static_cast<int>(voxel / area)};
  const int a = at[axis == 0 ? 1 : 0], b = at[axis == 2 ? 1 : 2];
  for (int db = -1; db <= 1; ++db)
    for (int da = -1; da <= 1; ++da) {
      const std::array<int, 3> near = in_slice(axis, at[axis], a + da, b + db);
      bool inside = true;
      for (int x = 0; x < 3; ++x) inside = inside && near[x] >= 0 && near[x] < all.size[x];
      if (inside && set[all.offset(near[0], near[1], near[2])] != 0) return true;
    }
  return false;
}

void require_parts(std::size_t parts, const char* what) {
  if (parts > static_cast<std::size_t>(kMaxDrawnParts))
    throw Error(what, "it has more than " + std::to_string(kMaxDrawnParts) + " parts", "draw fewer at once");
}

}  // namespace

std::vector<std::vector<Eigen::Vector3d>> paths_of_scribble(const Mask& mask) {
  const VoxelBox box = set_box(mask);
  const int axis = thinnest_axis(box);
  Mask part = cropped(mask, box);
  join_corners(part, axis);
  const Eigen::Affine3d index = part.geometry.index_from_world();
  const VoxelBox all{{0, 0, 0}, part.geometry.size};
  std::vector<std::uint8_t> near(part.voxels.size()), covered(part.voxels.size());
  // Sets `near` within a distance of a path in its slice.
  const auto set_near = [&](const std::vector<Eigen::Vector3d>& path, double reach_mm, std::uint8_t value) {
    for (const Eigen::Vector3d& mm : path) {
      const Eigen::Vector3d at = index * mm;
      std::array<int, 3> first, last;
      for (int x = 0; x < 3; ++x) {
        const double extent = x == axis ? 0 : reach_mm / part.geometry.spacing_mm[x];
        first[x] = std::max(0, static_cast<int>(std::ceil(at[x] - extent - 1e-6)));
        last[x] = std::min(all.size[x] - 1, static_cast<int>(std::floor(at[x] + extent + 1e-6)));
      }
      for (int k = first[2]; k <= last[2]; ++k)
        for (int j = first[1]; j <= last[1]; ++j)
          for (int i = first[0]; i <= last[0]; ++i) near[all.offset(i, j, k)] = value;
    }
  };
  std::vector<std::vector<Eigen::Vector3d>> paths;
  for_each_region(part, axis, [&](SliceRegion& region) {
    const std::vector<std::size_t> voxels = region.voxels();
    const bool is_rest = voxels.size() < kMinBranch &&
                         std::ranges::any_of(voxels, [&](std::size_t v) { return touches(covered, all, v, axis); });
    if (is_rest) return true;
    std::vector<Eigen::Vector3d> path = region.middle();
    const double reach_mm = 2 * region.deepest_mm() + part.geometry.spacing_mm.minCoeff();
    set_near(path, reach_mm, 1);
    for (const std::size_t v : voxels)
      if (near[v] != 0) part.voxels[v] = 0, covered[v] = 1;
    set_near(path, reach_mm, 0);
    paths.push_back(std::move(path));
    require_parts(paths.size(), "the scribble");
    return false;
  });
  return paths;
}

std::vector<DrawnContour> contours_of_lasso(const Mask& mask) {
  const VoxelBox box = set_box(mask);
  const int axis = thinnest_axis(box);
  Mask part = cropped(mask, box);
  const VoxelBox all{{0, 0, 0}, part.geometry.size};
  Slice slice{all.size[axis == 0 ? 1 : 0], all.size[axis == 2 ? 1 : 2], {}};
  for (int s = 0; s < all.size[axis]; ++s) {
    const auto offset = [&](int a, int b) {
      const std::array<int, 3> index = in_slice(axis, s, a, b);
      return all.offset(index[0], index[1], index[2]);
    };
    slice.set.resize(static_cast<std::size_t>(slice.size_a) * slice.size_b);
    for (int b = 0; b < slice.size_b; ++b)
      for (int a = 0; a < slice.size_a; ++a) slice.set[slice.at(a, b)] = part.voxels[offset(a, b)];
    fill(slice);
    for (int b = 0; b < slice.size_b; ++b)
      for (int a = 0; a < slice.size_a; ++a) part.voxels[offset(a, b)] = slice.set[slice.at(a, b)];
  }
  std::vector<std::pair<std::size_t, DrawnContour>> found;
  for_each_region(part, axis, [&](SliceRegion& region) {
    const std::vector<Eigen::Vector2d> corners = region.outline();
    // Middles of the faces along the border, which follow oblique borders more smoothly than the corners.
    const std::size_t step = corners.size() / kMaxVertices + 1;
    DrawnContour drawn{{}, region.normal()};
    for (std::size_t c = 0; c < corners.size(); c += step) {
      const Eigen::Vector2d middle = 0.5 * (corners[c] + corners[(c + 1) % corners.size()]);
      drawn.contour_mm.push_back(region.place(middle[0], middle[1]));
    }
    found.emplace_back(region.voxel_count(), std::move(drawn));
    require_parts(found.size(), "the lasso");
    return true;
  });
  const bool has_large = std::ranges::any_of(found, [](const auto& area) { return area.first >= kMinArea; });
  std::vector<DrawnContour> contours;
  for (auto& [voxels, drawn] : found)
    if (!has_large || voxels >= kMinArea) contours.push_back(std::move(drawn));
  return contours;
}

}  // namespace simplexseg
