// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_position.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/expect.h"

namespace simplexseg {

double same_position_mm(double spacing_mm, double coordinate_mm) {
  constexpr double kFraction = 0.01, kMaxFraction = 0.1;
  const double rounding = std::numeric_limits<float>::epsilon() * coordinate_mm;
  if (!(spacing_mm > 0)) return rounding;
  return std::clamp(rounding, kFraction * spacing_mm, kMaxFraction * spacing_mm);
}

double same_position_mm(std::span<const DicomSlice> slices) {
  double spacing = 0, coordinate = 0;
  const auto add = [&](double length) {
    if (length > 0 && (spacing == 0 || length < spacing)) spacing = length;
  };
  for (const DicomSlice& s : slices) {
    if (s.position) coordinate = std::max(coordinate, s.position->cwiseAbs().maxCoeff());
    if (s.spacing_mm) add(s.spacing_mm->minCoeff());
    const double distance = s.slice_distance_mm.value_or(0);
    add(distance > 0 ? distance : s.thickness_mm.value_or(0));
  }
  if (spacing == 0 && slices.size() > 1 && slices.front().axes) {
    const Eigen::Vector3d normal = slice_normal(slices.front());
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const DicomSlice& s : slices) {
      if (!s.position) continue;
      low = std::min(low, normal.dot(*s.position)), high = std::max(high, normal.dot(*s.position));
    }
    if (high > low) spacing = (high - low) / static_cast<double>(slices.size() - 1);
  }
  return same_position_mm(spacing, coordinate);
}

Eigen::Vector3d slice_normal(const DicomSlice& slice) {
  SIMPLEXSEG_EXPECT(slice.axes.has_value());
  return slice.axes->col(0).cross(slice.axes->col(1)).normalized();
}

}  // namespace simplexseg
