// SPDX-License-Identifier: Apache-2.0
#include "cli/click_picture.h"

#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "field/robot_user.h"

namespace simplexseg {
namespace {

constexpr int kMargin = 8;      ///< margin around truth and result, voxels
constexpr double kPanel = 420;  ///< longest side of a slice, pixels
constexpr Colour kTruth{60, 220, 90}, kResult{255, 150, 30}, kField{60, 200, 255};

/// One slice along two voxel axes; all pixels have the same size in mm.
struct Slice {
  std::array<int, 3> axes;  ///< voxel axes: right, down, normal to the slice
  int level;
  VoxelBox box;
  double scale_right, scale_down;  ///< pixels per voxel
  int left, width, height;

  std::array<int, 3> voxel(int x, int y) const {
    std::array<int, 3> v;
    v[axes[0]] = box.first[axes[0]] + std::min(static_cast<int>(x / scale_right), box.size[axes[0]] - 1);
    v[axes[1]] = box.first[axes[1]] + std::min(static_cast<int>(y / scale_down), box.size[axes[1]] - 1);
    v[axes[2]] = level;
    return v;
  }
};

}  // namespace

Picture draw_clicks(const Volume& image, const Mask& truth, const Mask& result, const Mask& field,
                    std::span<const Mark> marks) {
  const VolumeGeometry& g = image.geometry();
  VoxelBox box = bounding_box(truth, result);
  for (int a = 0; a < 3; ++a) {
    const int first = std::max(box.first[a] - kMargin, 0);
    box.size[a] = std::min(box.first[a] + box.size[a] + kMargin, g.size[a]) - first;
    box.first[a] = first;
  }
  std::optional<WorstError> focus = worst_error(truth, result);
  if (!focus) focus = deepest_voxel(truth);
  double longest = 0;
  for (int a = 0; a < 3; ++a) longest = std::max(longest, box.size[a] * g.spacing_mm[a]);
  const double pixels_per_mm = kPanel / std::max(longest, 1e-6);

  Picture picture;
  std::vector<Slice> slices;
  for (const std::array<int, 3>& axes : {std::array{0, 1, 2}, std::array{1, 2, 0}, std::array{0, 2, 1}}) {
    Slice slice{axes, focus ? focus->voxel[axes[2]] : box.first[axes[2]], box, 0, 0, picture.width, 0, 0};
    slice.scale_right = pixels_per_mm * g.spacing_mm[axes[0]], slice.scale_down = pixels_per_mm * g.spacing_mm[axes[1]];
    slice.width = std::max(1, static_cast<int>(box.size[axes[0]] * slice.scale_right));
    slice.height = std::max(1, static_cast<int>(box.size[axes[1]] * slice.scale_down));
    picture.width += slice.width + 4;
    picture.height = std::max(picture.height, slice.height);
    slices.push_back(slice);
  }
  picture.rgb.assign(3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height), 0);
  std::vector<double> values;
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i) {
        const double value = image.value(box.first[0] + i, box.first[1] + j, box.first[2] + k);
        if (std::isfinite(value)) values.push_back(value);
      }
  if (values.empty()) return picture;
  std::sort(values.begin(), values.end());
  const double low = values[values.size() / 100],
               high = std::max(values[values.size() - 1 - values.size() / 100], low + 1e-9);

  for (const Slice& slice : slices) {
    const auto set = [&](int x, int y, const Colour& c) {
      std::uint8_t* const p = &picture.rgb[3 * (std::size_t(y) * picture.width + slice.left + x)];
      p[0] = c.red, p[1] = c.green, p[2] = c.blue;
    };
    const auto in = [&](const Mask& mask, int x, int y) {
      const std::array<int, 3> v = slice.voxel(x, y);
      return mask.voxels[image.offset(v[0], v[1], v[2])] != 0;
    };
    for (int y = 0; y < slice.height; ++y)
      for (int x = 0; x < slice.width; ++x) {
        const std::array<int, 3> v = slice.voxel(x, y);
        const double share = std::clamp((image.value(v[0], v[1], v[2]) - low) / (high - low), 0.0, 1.0);
        const auto grey = static_cast<std::uint8_t>(std::isfinite(share) ? 255 * share : 0);
        set(x, y, {grey, grey, grey});
        for (const auto& [mask, colour] :
             {std::pair{&truth, kTruth}, std::pair{&field, kField}, std::pair{&result, kResult}})
          if (!mask->voxels.empty() && x + 1 < slice.width && y + 1 < slice.height &&
              (in(*mask, x, y) != in(*mask, x + 1, y) || in(*mask, x, y) != in(*mask, x, y + 1)))
            set(x, y, colour);
      }
    for (const Mark& mark : marks) {
      const Eigen::Vector3d index = g.index_from_world() * mark.position_mm;
      const int axis = slice.axes[2];
      const double away = std::abs(index[axis] - slice.level) * g.spacing_mm[axis];
      if (away > std::max(mark.radius_mm, g.spacing_mm[axis])) continue;
      const double radius =
          std::max(3.0, std::sqrt(std::max(0.0, mark.radius_mm * mark.radius_mm - away * away)) * pixels_per_mm);
      const double cx = (index[slice.axes[0]] + 0.5 - box.first[slice.axes[0]]) * slice.scale_right,
                   cy = (index[slice.axes[1]] + 0.5 - box.first[slice.axes[1]]) * slice.scale_down;
      const Colour colour = mark.kind == MarkKind::Inside    ? Colour{90, 160, 255}
                            : mark.kind == MarkKind::Outside ? Colour{255, 70, 70}
                                                             : Colour{255, 255, 255};
      for (double t = 0; t < 6.283; t += 0.5 / radius) {
        const int x = static_cast<int>(cx + radius * std::cos(t)), y = static_cast<int>(cy + radius * std::sin(t));
        if (x >= 0 && y >= 0 && x < slice.width && y < slice.height) set(x, y, colour);
      }
    }
  }
  return picture;
}

}  // namespace simplexseg
