// SPDX-License-Identifier: Apache-2.0
#include "evidence/field_object.h"

#include <algorithm>
#include <climits>
#include <iterator>

#include "evidence/connected.h"

namespace simplexseg {
namespace {

/// What is counted in one plane of the box.
struct PartOfObject {
  std::array<int, 3> low{INT_MAX, INT_MAX, INT_MAX}, high{-1, -1, -1};
  std::size_t count = 0, near = 0, near_object = 0;
};

/// Sets the object's voxels of a plane: those that are not open.
PartOfObject close_plane(std::span<const std::uint8_t> open, std::span<std::uint8_t> object, const VoxelBox& box,
                         int k) {
  PartOfObject part;
  for (int j = 0; j < box.size[1]; ++j) {
    const int width = box.size[0], row_to_side = std::min({j, k, box.size[1] - 1 - j, box.size[2] - 1 - k});
    const std::size_t row = box.offset(0, j, k);
    for (int i = 0; i < width; ++i) {
      object[row + i] = !open[row + i];
      part.count += object[row + i];
    }
    const auto count = [&](int first, int end) {
      part.near += end - first;
      for (int i = first; i < end; ++i) part.near_object += object[row + i];
    };
    const int side = row_to_side <= kNearSide ? width : std::min(kNearSide + 1, width);
    count(0, side);
    count(std::max(side, width - kNearSide - 1), width);
    const auto begin = object.begin() + static_cast<std::ptrdiff_t>(row), end = begin + width;
    const auto first = std::find(begin, end, 1);
    if (first == end) continue;
    const auto last = std::find(std::make_reverse_iterator(end), std::make_reverse_iterator(begin), 1);
    const int from = static_cast<int>(first - begin), to = static_cast<int>(last.base() - begin) - 1;
    part.low = {std::min(part.low[0], from), std::min(part.low[1], j), k};
    part.high = {std::max(part.high[0], to), j, k};
  }
  return part;
}

}  // namespace

FieldObject object_of_field(std::span<const float> field, std::span<const Constraint> known, const VoxelBox& box,
                            const RunJobs& run) {
  const int n = static_cast<int>(field.size()), planes = box.size[2], plane = planes == 0 ? 0 : n / planes;
  FieldObject object{std::vector<std::uint8_t>(n)};
  std::vector<std::uint8_t> start(n), open(n);
  for_each_index(run, n, [field, known, voxels = object.voxels.data(), start = start.data()](int v) {
    voxels[v] = field[v] > 0.5f;
    start[v] = known[v] == Constraint::Inside;
  });
  keep_connected(object.voxels, start, box.size);
  run(planes, [&](int k) {
    for (int v = k * plane; v < (k + 1) * plane; ++v) {
      open[v] = !object.voxels[v];
      start[v] = is_excluded(known[v]);
    }
    for (int j = 0; j < box.size[1]; ++j) {
      const auto row = start.begin() + static_cast<std::ptrdiff_t>(box.offset(0, j, k));
      if (k == 0 || j == 0 || k == planes - 1 || j == box.size[1] - 1)
        std::fill_n(row, box.size[0], 1);
      else
        row[0] = row[box.size[0] - 1] = 1;
    }
  });
  keep_connected(open, start, box.size);

  std::vector<PartOfObject> parts(planes);
  run(planes, [&](int k) { parts[k] = close_plane(open, object.voxels, box, k); });
  std::array<int, 3> low = box.size, high{-1, -1, -1};
  std::size_t near = 0, near_object = 0;
  for (const PartOfObject& part : parts) {
    object.count += part.count;
    near += part.near;
    near_object += part.near_object;
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], part.low[a]);
      high[a] = std::max(high[a], part.high[a]);
    }
  }
  if (high[0] >= 0) {
    for (int a = 0; a < 3; ++a) {
      object.around.first[a] = box.first[a] + low[a];
      object.around.size[a] = high[a] - low[a] + 1;
    }
  }
  if (near > 0) object.border_share = static_cast<double>(near_object) / static_cast<double>(near);
  return object;
}

}  // namespace simplexseg
