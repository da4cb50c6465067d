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

std::vector<std::optional<ModelCase>> load_model_cases(const TableCase& row, int image_number,
                                                       std::vector<std::string>& warnings) {
  const Volume image = read_volume(row.image);
  const std::string checksum = checksum_of(image);
  const Volume shown = row.mirror ? mirrored(image) : image;
  std::vector<std::optional<ModelCase>> cases;
  for (const OrganLabels& organ : row.organs) {
    std::optional<ModelCase>& one = cases.emplace_back();
    if (organ.labels.empty()) continue;
    LabelFile file(organ.labels);
    LabelChoice choice;
    choice.label = parse_number(organ.label);
    if (!choice.label) choice.name = organ.label;
    choice.label = label_of(choice, file.segments(), organ.labels);
    const Volume labels = file.read_onto(image.geometry(), quoted(row.image), warnings, choice);
    one = ModelCase{row.name, shown, mask_of(labels, choice.label), {checksum, checksum_of(labels)}, image_number};
    if (std::ranges::find(one->object.voxels, std::uint8_t{1}) == one->object.voxels.end())
      throw Error("case " + row.name, "no voxel of " + quoted(organ.labels) + " has the label " + organ.label,
                  "correct the label in the table");
    if (row.mirror)
      reverse_axis(std::span(one->object.voxels), image.geometry().size, left_right_axis(image.geometry()));
  }
  return cases;
}

IntensityScale scale_for(const std::vector<ModelCase>& cases) {
  const bool is_ct = std::ranges::all_of(cases, [](const ModelCase& one) { return one.image.range().min <= kAir; });
  return is_ct ? IntensityScale::Hounsfield : IntensityScale::Percentiles;
}

}  // namespace simplexseg
