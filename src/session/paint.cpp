// SPDX-License-Identifier: Apache-2.0
#include "session/paint.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>
#include <unordered_map>
#include <utility>

#include "field/field_value.h"
#include "forces/step_view.h"
#include "image/label_surface.h"
#include "image/rasterise.h"
#include "image/voxel_rows.h"
#include "session/field_voxels.h"

namespace simplexseg {
namespace {

constexpr int kMargin = 3;                    // cells of the box around paint
constexpr std::size_t kMaxCells = 8'000'000;  // of a box that is enlarged for paint
constexpr int kSamples = 3;                   // samples of a cell larger than a voxel, along each axis

/// Paint on the cells of a grid, at kSamples^3 samples of each, or one for cells of a voxel.
class PaintedCells {
 public:
  PaintedCells(const VolumeGeometry& cells, bool are_voxels)
      : all_{{0, 0, 0}, cells.size}, per_axis_(are_voxels ? 1 : kSamples), samples_(cells) {
    const Eigen::Affine3d world = cells.world_from_index();
    samples_.origin_mm = world * Eigen::Vector3d::Constant(0.5 / per_axis_ - 0.5);
    samples_.spacing_mm = cells.spacing_mm / per_axis_;
    for (int a = 0; a < 3; ++a) samples_.size[a] = cells.size[a] * per_axis_;
  }

  void add(const PaintStroke& stroke) {
    voxels_of(stroke, samples_).for_each([&](int i, int j, int k, bool inside) {
      const int n = per_axis_, sample = (k % n * n + j % n) * n + i % n;
      samples_of_[all_.offset(i / n, j / n, k / n)][sample] = inside ? VoxelPaint::Inside : VoxelPaint::Outside;
    });
  }

  bool empty() const { return samples_of_.empty(); }

  /// Bounding box of the cells with paint, with a margin.
  VoxelBox box() const {
    std::array<int, 3> low = all_.size, high{-1, -1, -1};
    for (const auto& [cell, samples] : samples_of_) {
      const std::array<int, 3> at = index_of(cell);
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
    }
    VoxelBox box{};
    for (int a = 0; a < 3; ++a) {
      box.first[a] = std::max(low[a] - kMargin, 0);
      box.size[a] = std::max(std::min(high[a] + kMargin + 1, all_.size[a]) - box.first[a], 0);
    }
    return box;
  }

  /// Calls use(cell, share inside, share outside) for each cell with paint.
  template <class Use>
  void for_each(Use&& use) const {
    const float part = 1.0f / static_cast<float>(per_axis_ * per_axis_ * per_axis_);
    for (const auto& [cell, samples] : samples_of_)
      use(index_of(cell), part * static_cast<float>(std::ranges::count(samples, VoxelPaint::Inside)),
          part * static_cast<float>(std::ranges::count(samples, VoxelPaint::Outside)));
  }

 private:
  std::array<int, 3> index_of(std::size_t cell) const {
    const auto row = static_cast<std::size_t>(all_.size[0]), plane = row * static_cast<std::size_t>(all_.size[1]);
    return {static_cast<int>(cell % row), static_cast<int>(cell % plane / row), static_cast<int>(cell / plane)};
  }

  VoxelBox all_;
  int per_axis_;
  VolumeGeometry samples_;
  std::unordered_map<std::size_t, std::array<VoxelPaint, kSamples * kSamples * kSamples>> samples_of_;
};

/// Sets the probabilities of the cells whose 26 neighbours are painted like themselves to their smoothed object mask:
/// inside a frozen part, the surface then has no steps. `painted`: box of the paint with a margin.
void smooth_painted_cells(std::span<const std::uint32_t> cells, const std::vector<std::uint8_t>& object,
                          std::vector<float>& probability, const VoxelBox& box, const VoxelBox& painted) {
  VoxelBox part = painted;
  for (int a = 0; a < 3; ++a) {
    part.first[a] = std::max(painted.first[a], box.first[a]);
    part.size[a] = std::min(painted.first[a] + painted.size[a], box.first[a] + box.size[a]) - part.first[a];
    if (part.size[a] <= 0) return;
  }
  std::vector<std::uint8_t> near(part.voxel_count()), is_painted(near.size());
  copy_from_outer(object.data(), box, near.data(), part);
  const auto in_part = [&](std::size_t v) {
    const auto [row, i] = std::lldiv(static_cast<long long>(v), box.size[0]);
    const auto [k, j] = std::lldiv(row, box.size[1]);
    return std::array<int, 3>{static_cast<int>(i) + box.first[0] - part.first[0],
                              static_cast<int>(j) + box.first[1] - part.first[1],
                              static_cast<int>(k) + box.first[2] - part.first[2]};
  };
  for (const std::size_t v : cells) {
    const auto [i, j, k] = in_part(v);
    is_painted[part.offset(i, j, k)] = 1;
  }
  const std::vector<float> share = smoothed_voxels(near, part);
  for (const std::size_t v : cells) {
    const auto [i, j, k] = in_part(v);
    bool enclosed = i > 0 && j > 0 && k > 0 && i + 1 < part.size[0] && j + 1 < part.size[1] && k + 1 < part.size[2];
    for (int c = k - 1; enclosed && c <= k + 1; ++c)
      for (int b = j - 1; enclosed && b <= j + 1; ++b)
        for (int a = i - 1; enclosed && a <= i + 1; ++a) enclosed = is_painted[part.offset(a, b, c)] != 0;
    if (enclosed) probability[v] = std::clamp(share[part.offset(i, j, k)], 0.0f, 1.0f);
  }
}

VoxelBox united(const VoxelBox& a, const VoxelBox& b) {
  VoxelBox box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.first[axis] = std::min(a.first[axis], b.first[axis]);
    box.size[axis] = std::max(a.first[axis] + a.size[axis], b.first[axis] + b.size[axis]) - box.first[axis];
  }
  return box;
}

}  // namespace

PaintStroke paint_stroke_of(const UserPoint& point) {
  return {point.kind == MarkKind::Inside, point.vertices_mm(), point.radius_mm, point.brush, point.voxels};
}

std::vector<PaintStroke> paint_of(const Scene& scene, ItemId mesh) {
  std::vector<PaintStroke> paint;
  for (const UserPoint& point : scene.points)
    if (point.mesh == mesh && point.is_paint()) paint.push_back(paint_stroke_of(point));
  return paint;
}

Mask object_mask(const SimplexMesh& mesh, const std::vector<PaintStroke>& paint, const VolumeGeometry& grid) {
  Mask mask = rasterise(mesh, grid);
  for (const PaintStroke& stroke : paint) apply(stroke, mask);
  return mask;
}

std::vector<float> object_fractions(const SimplexMesh& mesh, const std::vector<PaintStroke>& paint,
                                    const VolumeGeometry& grid) {
  std::vector<float> fractions = inside_fractions(mesh, grid);
  const VoxelBox all{{0, 0, 0}, grid.size};
  for (const PaintStroke& stroke : paint)
    voxels_of(stroke, grid).for_each([&](int i, int j, int k, bool inside) {
      fractions[all.offset(i, j, k)] = inside ? 1.0f : 0.0f;
    });
  return fractions;
}

std::shared_ptr<const MeshField> painted_field(std::shared_ptr<const MeshField> solved, std::vector<PaintStroke> paint,
                                               const VolumeGeometry& volume) {
  if (paint.empty() || solved->values.empty()) return solved;
  const VolumeGeometry cells = cell_geometry(volume, solved->cell);
  PaintedCells painted(cells, solved->cell == kVoxelCells);
  for (const PaintStroke& stroke : paint) painted.add(stroke);
  auto field = std::make_shared<MeshField>(*solved);
  if (painted.empty()) {
    field->paint = std::move(paint), field->solved = std::move(solved);
    return field;
  }
  if (const VoxelBox box = united(solved->box, painted.box()); box.voxel_count() <= kMaxCells) field->box = box;
  const std::size_t count = field->box.voxel_count();
  // The half lets values that do not change be encoded to the same integers again.
  std::vector<std::uint16_t> values(count, 0);
  copy_into_outer(solved->values.data(), solved->box, values.data(), field->box);
  std::vector<std::uint8_t> object(count);
  std::vector<float> probability(count);
  for (std::size_t v = 0; v < count; ++v) {
    object[v] = static_cast<float>(values[v]) > 0.5f * kFieldScale;
    probability[v] = (static_cast<float>(values[v]) + 0.5f) / kFieldScale;
  }
  field->painted_cells.clear();
  painted.for_each([&](const std::array<int, 3>& cell, float inside, float outside) {
    std::array<int, 3> at;
    for (int a = 0; a < 3; ++a) {
      at[a] = cell[a] - field->box.first[a];
      if (at[a] < 0 || at[a] >= field->box.size[a]) return;
    }
    const std::size_t v = field->box.offset(at[0], at[1], at[2]);
    const float p = inside + (1 - inside - outside) * static_cast<float>(object[v]);
    object[v] = p > 0.5f, probability[v] = p;
    if (inside + outside == 1) field->painted_cells.push_back(static_cast<std::uint32_t>(v));
  });
  std::ranges::sort(field->painted_cells);
  smooth_painted_cells(field->painted_cells, object, probability, field->box, painted.box());
  field->values = field_values(object, probability, field->box, cells, field_value_of(cells), run_serially());
  field->paint = std::move(paint);
  field->solved = std::move(solved);
  return field;
}

}  // namespace simplexseg
