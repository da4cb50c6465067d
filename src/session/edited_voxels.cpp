// SPDX-License-Identifier: Apache-2.0
#include "session/edited_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/quantile.h"
#include "image/gaussian.h"
#include "image/label_surface.h"
#include "image/voxel_box.h"
#include "image/voxel_rows.h"
#include "session/label_map.h"
#include "session/paint.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace {

constexpr double kDeviations = 3;  // of SmartPaint: accepted difference from the median, standard deviations

/// Box of a grid in which the object of a mesh lies.
VoxelBox box_of_object(const Scene& scene, const MeshItem& item, const VolumeGeometry& grid) {
  const Eigen::Affine3d index = grid.index_from_world();
  VoxelBox box{};
  if (!item.mesh.positions.empty()) {
    Eigen::Vector3d low = index * item.mesh.positions[0].cast<double>(), high = low;
    for (const Eigen::Vector3f& p : item.mesh.positions) {
      const Eigen::Vector3d at = index * p.cast<double>();
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
    for (int a = 0; a < 3; ++a) {
      const double last = grid.size[a] - 1.0;
      box.first[a] = static_cast<int>(std::clamp(std::floor(low[a]), 0.0, last));
      box.size[a] = static_cast<int>(std::clamp(std::ceil(high[a]), 0.0, last)) - box.first[a] + 1;
    }
  }
  for (const PaintStroke& stroke : paint_of(scene, item.id)) box = united(box, voxels_of(stroke, grid).box);
  return box;
}

std::vector<std::uint8_t> complement(const std::vector<std::uint8_t>& voxels) {
  std::vector<std::uint8_t> others(voxels.size());
  for (std::size_t v = 0; v < voxels.size(); ++v) others[v] = !voxels[v];
  return others;
}

void move_surface(Mask& mask, double distance_mm) {
  const VoxelBox box{{0, 0, 0}, mask.geometry.size};
  const Eigen::Matrix3d mm_from_index = mask.geometry.world_from_index().linear();
  const bool grows = distance_mm > 0;
  const auto reach_mm = static_cast<float>(std::abs(distance_mm) * (1 + 1e-6));
  if (reach_mm == 0) return;
  const std::vector<float> to_other_mm =
      distance_map(grows ? mask.voxels : complement(mask.voxels), box, mm_from_index, reach_mm);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v)
    if (to_other_mm[v] <= reach_mm) mask.voxels[v] = grows;
}

void smooth_mask(Mask& mask, double deviation_mm) {
  const VoxelBox box{{0, 0, 0}, mask.geometry.size};
  std::array<double, 3> deviation_voxels;
  for (int a = 0; a < 3; ++a) deviation_voxels[a] = deviation_mm / mask.geometry.spacing_mm[a];
  std::vector<float> share(mask.voxels.begin(), mask.voxels.end());
  smooth_gaussian(share, box, deviation_voxels);
  // Below 1 near the sides of the volume, which do not shrink the object.
  const GaussianOfOnes all(box, deviation_voxels);
  std::size_t v = 0;
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i, ++v) mask.voxels[v] = share[v] > 0.5f * all(i, j, k);
}

void remove_parts(Mask& mask, std::size_t least_voxels) {
  for (const std::vector<std::size_t>& part : connected_components(mask))
    if (part.size() < least_voxels)
      for (const std::size_t v : part) mask.voxels[v] = 0;
}

void keep_largest_part(Mask& mask) {
  const std::vector<std::vector<std::size_t>> parts = connected_components(mask);
  for (std::size_t p = 1; p < parts.size(); ++p)
    for (const std::size_t v : parts[p]) mask.voxels[v] = 0;
}

/// Distance in mm beyond the object in which an edit may set voxels.
double reach_of(VoxelEdit edit, double size) {
  return edit == VoxelEdit::Margin ? std::max(size, 0.0) : edit == VoxelEdit::Smooth ? 3 * size : 0;
}

/// Intensities of the voxels of a box as floats.
std::vector<float> intensities(const Volume& volume, const VoxelBox& box) {
  std::vector<float> values(box.voxel_count());
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    for_each_row(box, {{0, 0, 0}, volume.geometry().size}, [&](std::size_t in_box, std::size_t in_volume) {
      for (int i = 0; i < box.size[0]; ++i) values[in_box + i] = static_cast<float>(voxels[in_volume + i]);
    });
  });
  return values;
}

/// Voxels of the stroke with the intensities along its path.
Mask similar_voxels(const StrokeVoxels& covered, const StrokeVoxels& core, const Volume& volume) {
  const std::vector<float> values = intensities(volume, covered.box);
  const auto in_covered = [&](int i, int j, int k) {
    return covered.box.offset(i - covered.box.first[0], j - covered.box.first[1], k - covered.box.first[2]);
  };
  std::vector<std::size_t> reached;
  std::vector<float> along;
  core.for_each([&](int i, int j, int k, bool) { reached.push_back(in_covered(i, j, k)); });
  for (const std::size_t v : reached)
    if (!std::isnan(values[v])) along.push_back(values[v]);
  Mask similar{grid_of_box(volume.geometry(), covered.box), std::vector<std::uint8_t>(values.size())};
  if (along.empty()) return similar;
  const float median = quantile(along, 0.5);
  for (float& value : along) value = std::abs(value - median);
  const float tolerance = static_cast<float>(kDeviations * kDeviationsOfMedian) * quantile(along, 0.5);
  std::erase_if(reached, [&](std::size_t v) { return !(std::abs(values[v] - median) <= tolerance); });
  for (const std::size_t v : reached) similar.voxels[v] = 1;
  const auto [ni, nj, nk] = covered.box.size;
  const std::size_t stride[3] = {1, static_cast<std::size_t>(ni), static_cast<std::size_t>(ni) * nj};
  for (std::size_t n = 0; n < reached.size(); ++n) {
    const std::size_t v = reached[n];
    const int at[3] = {static_cast<int>(v % ni), static_cast<int>(v / ni % nj), static_cast<int>(v / stride[2])};
    for (int a = 0; a < 3; ++a)
      for (const int step : {-1, 1}) {
        if (at[a] + step < 0 || at[a] + step >= covered.box.size[a]) continue;
        const std::size_t to = step > 0 ? v + stride[a] : v - stride[a];
        if (similar.voxels[to] || covered.voxels[to] == VoxelPaint::None) continue;
        if (!(std::abs(values[to] - median) <= tolerance)) continue;
        similar.voxels[to] = 1;
        reached.push_back(to);
      }
  }
  fill_cavities(similar, similar.voxels.size());  // voxels of noise
  return similar;
}

}  // namespace

std::shared_ptr<const PaintVoxels> edited_voxels(const Scene& scene, const MeshItem& item, VoxelEdit edit, double size,
                                                 const MeshItem* other, const VolumeGeometry& grid) {
  const VoxelEditInfo& info = info_of(edit);
  const std::string name = std::string(info.title) + ", segmentation '" + item.name + "'";
  if (info.uses_stroke) throw Error(name, "it needs a stroke", "draw one");
  if (info.uses_other && (!other || other->id == item.id))
    throw Error(name, "it needs another segmentation", "choose one of the scene");
  if (info.size.name[0] != '\0') check_value(info.size, static_cast<float>(size), info.title);
  std::array<int, 3> margin;
  const Eigen::Matrix3d index_from_mm = grid.index_from_world().linear();
  for (int a = 0; a < 3; ++a) {
    const double reach = std::ceil(reach_of(edit, size) * index_from_mm.row(a).norm()) + 1;
    margin[a] = static_cast<int>(std::min(reach, static_cast<double>(grid.size[a])));
  }
  VoxelBox box = box_of_object(scene, item, grid);
  if (edit == VoxelEdit::Add) box = united(box, box_of_object(scene, *other, grid));
  box = widened(box, margin, grid.size);
  if (box.voxel_count() == 0) throw Error(name, "it lies outside the image", "move it into the image");
  const VolumeGeometry part = grid_of_box(grid, box);
  const Mask before = object_mask(item.mesh, paint_of(scene, item.id), part);
  Mask after = before, others;
  if (other) others = object_mask(other->mesh, paint_of(scene, other->id), part);
  switch (edit) {
    case VoxelEdit::KeepLargest:
      keep_largest_part(after);
      break;
    case VoxelEdit::RemoveSmall:
      remove_parts(after,
                   static_cast<std::size_t>(std::ceil(size * std::abs(index_from_mm.determinant()) * (1 - 1e-9))));
      break;
    case VoxelEdit::FillHoles:
      fill_cavities(after, after.voxels.size());
      break;
    case VoxelEdit::Margin:
      move_surface(after, size);
      break;
    case VoxelEdit::Smooth:
      smooth_mask(after, size);
      break;
    case VoxelEdit::Add:
      for (std::size_t v = 0; v < after.voxels.size(); ++v) after.voxels[v] |= others.voxels[v];
      break;
    case VoxelEdit::Subtract:
      for (std::size_t v = 0; v < after.voxels.size(); ++v) after.voxels[v] &= !others.voxels[v];
      break;
    case VoxelEdit::Intersect:
      for (std::size_t v = 0; v < after.voxels.size(); ++v) after.voxels[v] &= others.voxels[v];
      break;
    case VoxelEdit::None:
    case VoxelEdit::SmartPaint:
    case VoxelEdit::Freeze:
      break;
  }
  std::shared_ptr<const PaintVoxels> changed = difference_of(before, after);
  if (!changed) throw Error(name, "it would change no voxel", "nothing needs to be done");
  if (std::ranges::count(after.voxels, 1) == 0)
    throw Error(name, "it would remove the whole object", "use a smaller value, or delete the segmentation");
  return changed;
}

std::shared_ptr<const PaintVoxels> stroked_voxels(const Scene& scene, const MeshItem& item, const UserPoint& stroke,
                                                  const Volume& volume) {
  const VolumeGeometry& grid = volume.geometry();
  PaintStroke path = paint_stroke_of(stroke);
  const StrokeVoxels covered = voxels_of(path, grid);
  if (covered.voxels.empty()) throw Error(info_of(stroke.edit).title, "no voxel lies under the stroke", "enlarge it");
  auto paint = std::make_shared<PaintVoxels>();
  paint->box = grid_of_box(grid, covered.box);
  paint->voxels = covered.voxels;
  Mask inside;
  if (stroke.edit == VoxelEdit::Freeze) {
    inside = object_mask(item.mesh, paint_of(scene, item.id), paint->box);
  } else {
    path.radius_mm *= 0.5;
    inside = similar_voxels(covered, voxels_of(path, grid), volume);
  }
  std::vector<char> of_others(paint->voxels.size());  // voxels of the object whose label is that of another one
  if (stroke.edit == VoxelEdit::Freeze && scene.meshes.size() > 1) {
    const LabelMap owners = make_label_map(scene, paint->box, grid);
    visit_voxel_type(owners.labels.type(), [&]<class T>(std::type_identity<T>) {
      const std::span<const T> labels = owners.labels.voxels<T>();
      for (std::size_t v = 0; v < labels.size(); ++v) of_others[v] = static_cast<int>(labels[v]) != item.label;
    });
  }
  for (std::size_t v = 0; v < paint->voxels.size(); ++v) {
    if (paint->voxels[v] == VoxelPaint::None) continue;
    if (stroke.edit == VoxelEdit::Freeze)
      paint->voxels[v] = !inside.voxels[v] ? VoxelPaint::Outside : of_others[v] ? VoxelPaint::None : VoxelPaint::Inside;
    else if (!inside.voxels[v])
      paint->voxels[v] = VoxelPaint::None;
  }
  return paint;
}

}  // namespace simplexseg
