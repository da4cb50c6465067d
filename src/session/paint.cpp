// SPDX-License-Identifier: Apache-2.0
#include "session/paint.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <span>
#include <utility>

#include "field/field_value.h"
#include "forces/step_view.h"
#include "image/label_surface.h"
#include "image/rasterise.h"
#include "image/voxel_box.h"
#include "image/voxel_rows.h"
#include "session/field_voxels.h"

namespace simplexseg {
namespace {

constexpr int kMargin = 3;                    // cells of the box around paint
constexpr std::size_t kMaxCells = 8'000'000;  // of a box that is enlarged for paint
constexpr int kSamples = 3;                   // samples of a cell larger than a voxel, along each axis

/// Paint on the cells of a grid, at kSamples^3 samples of each, or one for cells of a voxel; stored in blocks of cells.
class PaintedCells {
 public:
  PaintedCells(const VolumeGeometry& cells, bool are_voxels)
      : size_(cells.size),
        per_axis_(are_voxels ? 1 : kSamples),
        per_cell_(static_cast<std::size_t>(per_axis_ * per_axis_ * per_axis_)),
        samples_(cells) {
    const Eigen::Affine3d world = cells.world_from_index();
    samples_.origin_mm = world * Eigen::Vector3d::Constant(0.5 / per_axis_ - 0.5);
    samples_.spacing_mm = cells.spacing_mm / per_axis_;
    for (int a = 0; a < 3; ++a) samples_.size[a] = cells.size[a] * per_axis_;
  }

  void add(const PaintStroke& stroke) {
    std::array<int, 3> last{-1, -1, -1};
    Block* block = nullptr;
    for_each_voxel(stroke, samples_, [&](int i, int j, int k, bool inside) {
      const int n = per_axis_, a = i / n, b = j / n, c = k / n;
      if (const std::array<int, 3> here{a / kSide, b / kSide, c / kSide}; !block || here != last) {
        last = here, block = &blocks_[here];
        if (block->empty()) block->assign(kSide * kSide * kSide * per_cell_, VoxelPaint::None);
      }
      const int cell = (c % kSide * kSide + b % kSide) * kSide + a % kSide;
      const int sample = (k % n * n + j % n) * n + i % n;
      (*block)[static_cast<std::size_t>(cell) * per_cell_ + static_cast<std::size_t>(sample)] =
          inside ? VoxelPaint::Inside : VoxelPaint::Outside;
    });
  }

  bool empty() const { return blocks_.empty(); }

  /// Bounding box of the cells with paint, with a margin.
  VoxelBox box() const {
    std::array<int, 3> low = size_, high{-1, -1, -1};
    for_each([&](const std::array<int, 3>& at, float, float) {
      for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
    });
    VoxelBox box{};
    for (int a = 0; a < 3; ++a) {
      box.first[a] = std::max(low[a] - kMargin, 0);
      box.size[a] = std::max(std::min(high[a] + kMargin + 1, size_[a]) - box.first[a], 0);
    }
    return box;
  }

  /// Calls use(cell, share inside, share outside) for each cell with paint.
  template <class Use>
  void for_each(Use&& use) const {
    const float part = 1.0f / static_cast<float>(per_cell_);
    for (const auto& [place, block] : blocks_)
      for (int cell = 0; cell < kSide * kSide * kSide; ++cell) {
        const auto samples = std::span(block).subspan(static_cast<std::size_t>(cell) * per_cell_, per_cell_);
        const auto inside = std::ranges::count(samples, VoxelPaint::Inside);
        const auto outside = std::ranges::count(samples, VoxelPaint::Outside);
        if (inside + outside == 0) continue;
        const std::array<int, 3> at{place[0] * kSide + cell % kSide, place[1] * kSide + cell / kSide % kSide,
                                    place[2] * kSide + cell / kSide / kSide};
        use(at, part * static_cast<float>(inside), part * static_cast<float>(outside));
      }
  }

 private:
  using Block = std::vector<VoxelPaint>;
  static constexpr int kSide = 8;  // side of a block, cells

  std::array<int, 3> size_;
  int per_axis_;
  std::size_t per_cell_;
  VolumeGeometry samples_;
  std::map<std::array<int, 3>, Block> blocks_;
};

/// Sets the probabilities of cells at the surface whose 26 neighbours are painted like themselves to their smoothed
/// object mask: inside a frozen part, the surface then has no steps. `painted`: box of the paint with a margin.
void smooth_painted_cells(std::span<const std::uint32_t> cells, const std::vector<std::uint8_t>& object,
                          std::vector<float>& probability, const VoxelBox& box, const VoxelBox& painted) {
  const VoxelBox part = common(painted, box);
  if (part.voxel_count() == 0) return;
  enum : std::uint8_t { kFree, kPainted, kInObject };
  std::vector<std::uint8_t> state(part.voxel_count(), kFree);
  const auto in_part = [&](std::size_t v) {
    const auto [row, i] = std::lldiv(static_cast<long long>(v), box.size[0]);
    const auto [k, j] = std::lldiv(row, box.size[1]);
    return std::array<int, 3>{static_cast<int>(i) + box.first[0] - part.first[0],
                              static_cast<int>(j) + box.first[1] - part.first[1],
                              static_cast<int>(k) + box.first[2] - part.first[2]};
  };
  for (const std::size_t v : cells) {
    const auto [i, j, k] = in_part(v);
    state[part.offset(i, j, k)] = object[v] ? kInObject : kPainted;
  }
  // Whether all neighbours are painted, some of them inside and some outside.
  const auto is_at_surface = [&](int i, int j, int k) {
    if (i < 1 || j < 1 || k < 1 || i + 1 >= part.size[0] || j + 1 >= part.size[1] || k + 1 >= part.size[2])
      return false;
    bool inside = false, outside = false;
    for (int c = k - 1; c <= k + 1; ++c)
      for (int b = j - 1; b <= j + 1; ++b)
        for (int a = i - 1; a <= i + 1; ++a) {
          const std::uint8_t here = state[part.offset(a, b, c)];
          if (here == kFree) return false;
          (here == kInObject ? inside : outside) = true;
        }
    return inside && outside;
  };
  std::vector<std::uint32_t> at_surface;
  constexpr int kReach = 6;  // of smoothed_voxels(), cells
  std::array<int, 3> low = part.size, high{-1, -1, -1};
  for (const std::uint32_t v : cells) {
    const std::array<int, 3> at = in_part(v);
    if (!is_at_surface(at[0], at[1], at[2])) continue;
    at_surface.push_back(v);
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
  }
  if (at_surface.empty()) return;
  VoxelBox around{};
  for (int a = 0; a < 3; ++a) {
    around.first[a] = part.first[a] + low[a] - kReach;
    around.size[a] = high[a] - low[a] + 1 + 2 * kReach;
  }
  around = common(around, box);
  std::vector<std::uint8_t> near(around.voxel_count());
  copy_from_outer(object.data(), box, near.data(), around);
  const std::vector<float> share = smoothed_voxels(near, around);
  for (const std::size_t v : at_surface) {
    const auto [i, j, k] = in_part(v);
    probability[v] =
        std::clamp(share[around.offset(i + part.first[0] - around.first[0], j + part.first[1] - around.first[1],
                                       k + part.first[2] - around.first[2])],
                   0.0f, 1.0f);
  }
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
    for_each_voxel(stroke, grid,
                   [&](int i, int j, int k, bool inside) { fractions[all.offset(i, j, k)] = inside ? 1.0f : 0.0f; });
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
  const VoxelBox painted_box = painted.box();
  if (const VoxelBox box = united(solved->box, painted_box); box.voxel_count() <= kMaxCells) field->box = box;
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
  smooth_painted_cells(field->painted_cells, object, probability, field->box, painted_box);
  field->values = field_values(object, probability, field->box, cells, field_value_of(cells), run_serially());
  field->paint = std::move(paint);
  field->solved = std::move(solved);
  return field;
}

}  // namespace simplexseg
