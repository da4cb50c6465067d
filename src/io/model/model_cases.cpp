// SPDX-License-Identifier: Apache-2.0
#include "io/model/model_cases.h"

#include <algorithm>

#include "core/error.h"
#include "core/number_text.h"
#include "io/labels/label_file.h"
#include "io/platform/files.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

constexpr double kAir = -500;  ///< HU

/// Axis of a grid that is nearest to left-right.
int left_right_axis(const VolumeGeometry& grid) {
  Eigen::Index axis = 0;
  grid.direction.row(0).cwiseAbs().maxCoeff(&axis);
  return static_cast<int>(axis);
}

/// Reverses the order of voxels along an axis.
template <class T>
void reverse_axis(std::span<T> voxels, const std::array<int, 3>& size, int axis) {
  const std::array<std::size_t, 3> stride{1, std::size_t(size[0]), std::size_t(size[0]) * size[1]};
  const std::size_t n = voxels.size();
  for (std::size_t v = 0; v < n; ++v) {
    const auto at = static_cast<int>(v / stride[axis] % size[axis]);
    const int other = size[axis] - 1 - at;
    if (at < other) std::swap(voxels[v], voxels[v + (other - at) * stride[axis]]);
  }
}

Volume mirrored(const Volume& image) {
  Volume result(image.geometry(), image.type());
  visit_voxel_type(image.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<T> voxels = result.voxels<T>();
    std::ranges::copy(image.voxels<T>(), voxels.begin());
    reverse_axis(voxels, image.geometry().size, left_right_axis(image.geometry()));
  });
  return result;
}

}  // namespace

ModelCase load_model_case(const TableCase& row, std::vector<std::string>& warnings) {
  ModelCase result;
  result.name = row.name;
  result.image = read_volume(row.image);
  LabelFile file(row.labels);
  LabelChoice choice;
  choice.label = parse_number(row.label);
  if (!choice.label) choice.name = row.label;
  choice.label = label_of(choice, file.segments(), row.labels);
  const Volume labels = file.read_onto(result.image.geometry(), quoted(row.image), warnings, choice);
  result.source = {checksum_of(result.image), checksum_of(labels)};
  result.object = mask_of(labels, choice.label);
  if (std::ranges::find(result.object.voxels, std::uint8_t{1}) == result.object.voxels.end())
    throw Error("case " + row.name, "no voxel of " + quoted(row.labels) + " has the label " + row.label,
                "correct the label in the table");
  if (row.mirror) {
    result.image = mirrored(result.image);
    reverse_axis(std::span(result.object.voxels), result.image.geometry().size,
                 left_right_axis(result.image.geometry()));
  }
  return result;
}

IntensityScale scale_for(const std::vector<ModelCase>& cases) {
  const bool is_ct = std::ranges::all_of(cases, [](const ModelCase& one) { return one.image.range().min <= kAir; });
  return is_ct ? IntensityScale::Hounsfield : IntensityScale::Percentiles;
}

}  // namespace simplexseg
