// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_stack.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/error.h"
#include "core/expect.h"
#include "core/number_text.h"
#include "io/dicom/dicom_position.h"
#include "io/dicom/dicom_scan.h"

namespace simplexseg {
namespace {

constexpr double kMaxUnevenness = 0.1;  ///< largest deviation from even spacing, as fraction of the slice distance

std::string mm(double length) { return general_text(length, 6) + " mm"; }

/// Returns the median of the distances; 0 when there are none.
double median_of(std::vector<double> gaps) {
  if (gaps.empty()) return 0;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>((gaps.size() - 1) / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

}  // namespace

bool same_plane(const DicomSlice& a, const DicomSlice& b) {
  if (a.axes.has_value() != b.axes.has_value()) return false;
  return !a.axes || (*a.axes - *b.axes).cwiseAbs().maxCoeff() <= 1e-3;
}

bool same_size(const DicomSlice& a, const DicomSlice& b) {
  if (a.pixels.rows != b.pixels.rows || a.pixels.columns != b.pixels.columns || a.pixels.samples != b.pixels.samples)
    return false;
  return a.spacing_mm.has_value() == b.spacing_mm.has_value() &&
         (!a.spacing_mm || a.spacing_mm->isApprox(*b.spacing_mm, 1e-3));
}

bool are_evenly_spaced(const std::vector<DicomSlice>& slices) {
  const auto is_placed = [](const DicomSlice& s) { return s.position && s.axes; };
  if (slices.size() < 2 || !std::all_of(slices.begin(), slices.end(), is_placed)) return false;
  const Eigen::Vector3d normal = slice_normal(slices.front());
  std::vector<double> places, gaps;
  for (const DicomSlice& s : slices) places.push_back(normal.dot(*s.position));
  std::sort(places.begin(), places.end());
  for (std::size_t i = 1; i < places.size(); ++i) gaps.push_back(places[i] - places[i - 1]);
  const double spacing = median_of(gaps), tolerance = same_position_mm(slices);
  return std::all_of(gaps.begin(), gaps.end(),
                     [&](double gap) { return gap > tolerance && std::abs(gap / spacing - 1) <= kMaxUnevenness; });
}

void require_one_stack(const std::vector<DicomSlice>& slices, const std::string& series_name) {
  SIMPLEXSEG_EXPECT(!slices.empty());
  const DicomSlice& first = slices.front();
  std::vector<std::string> without_position, sizes, orientations;
  for (const DicomSlice& s : slices) {
    if (!s.position || !s.axes) without_position.push_back(name_of(s));
    if (!same_size(s, first)) sizes.push_back(name_of(s));
    if (s.axes && first.axes && !same_plane(s, first)) orientations.push_back(name_of(s));
  }
  if (!orientations.empty()) {
    throw Error("cannot read " + series_name,
                "its slices have different orientations: " + list_of(orientations) + " differ from " + name_of(first),
                "move the slices of one orientation to a separate folder");
  }
  if (!sizes.empty()) {
    throw Error("cannot read " + series_name,
                "its slices have different sizes, pixel spacings or colours: " + list_of(sizes) + " differ from " +
                    name_of(first),
                "move the slices of one size to a separate folder");
  }
  if (!without_position.empty()) {
    throw Error("cannot read " + series_name,
                "these slices have no position or orientation: " + list_of(without_position),
                "export the series again with its image positions");
  }
}

void stack(std::vector<DicomSlice>& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings,
           const std::string& series_name) {
  SIMPLEXSEG_EXPECT(!slices.empty() && slices.front().axes && slices.front().position);
  const Eigen::Vector3d normal = slice_normal(slices.front());
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return std::tuple(place(a), a.file, a.frame) < std::tuple(place(b), b.file, b.frame);
  });
  const double same_mm = same_position_mm(slices);
  std::vector<double> gaps;
  std::vector<std::string> duplicate, missing, uneven;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double gap = place(slices[i]) - place(slices[i - 1]);
    if (gap > same_mm)
      gaps.push_back(gap);
    else
      duplicate.push_back(name_of(slices[i - 1]) + " and " + name_of(slices[i]));
  }
  const double spacing = median_of(gaps);
  double worst = 0;
  int missing_count = 0;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double gap = place(slices[i]) - place(slices[i - 1]);
    if (gap <= same_mm) continue;
    const double ratio = gap / spacing;
    const int places = static_cast<int>(std::lround(std::min(ratio, 1e6)));
    const std::string between = name_of(slices[i - 1]) + " and " + name_of(slices[i]);
    if (places >= 2 && std::abs(ratio - places) < kMaxUnevenness * places) {
      missing.push_back(std::to_string(places - 1) + " between " + between);
      missing_count += places - 1;
    } else if (std::abs(ratio - 1) > kMaxUnevenness) {
      uneven.push_back(mm(gap) + " between " + between);
    } else {
      worst = std::max(worst, std::abs(gap - spacing));
    }
  }
  if (!duplicate.empty() || !missing.empty() || !uneven.empty()) {
    std::string why, remedy;
    const auto add = [](std::string& to, const std::string& text) { to += (to.empty() ? "" : ", ") + text; };
    if (!missing.empty()) add(why, counted(missing_count, "missing slice") + " (" + list_of(missing) + ")");
    if (!duplicate.empty())
      add(why, counted(std::int64_t(duplicate.size()), "duplicate slice") + " (" + list_of(duplicate) + ")");
    if (!uneven.empty()) add(why, "uneven slice distances (" + list_of(uneven) + " instead of " + mm(spacing) + ")");
    if (!missing.empty()) add(remedy, "add the missing files");
    if (!duplicate.empty()) add(remedy, "keep one file for each position");
    if (!uneven.empty()) add(remedy, "move each stack of evenly spaced slices to a separate folder");
    throw Error("cannot read " + series_name, why, remedy);
  }
  const DicomSlice& first = slices.front();
  geometry.origin_mm = *first.position;
  geometry.direction.leftCols<2>() = *first.axes;
  geometry.direction.col(2) = normal;
  if (slices.size() == 1) return;

  const double count = double(slices.size() - 1);
  const Eigen::Vector3d shift = (*slices.back().position - *first.position) / count;
  const double along = normal.dot(shift), tilt = (shift - along * normal).norm() / along;
  double off_line = 0;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const Eigen::Vector3d off = *slices[i].position - *first.position - double(i) * shift;
    off_line = std::max(off_line, (off - normal.dot(off) * normal).norm());
  }
  const double pixel = first.spacing_mm ? first.spacing_mm->minCoeff() : 1;
  if (off_line > 0.5 * pixel) {
    throw Error("cannot read " + series_name, "its slices are shifted against each other by up to " + mm(off_line),
                "export the series again");
  }
  if (off_line > 0.1 * pixel) warnings.push_back("slices are shifted sideways by up to " + mm(off_line));
  // A tilt within rounding errors is ignored; a larger tilt (tilted gantry) makes the grid sheared.
  geometry.spacing_mm[2] = tilt < 1e-4 ? along : shift.norm();
  if (tilt >= 1e-4) geometry.direction.col(2) = shift.normalized();
  if (tilt > 1e-3) {
    warnings.push_back("tilted gantry: the stack deviates by " + general_text(std::atan(tilt) * 180 / M_PI, 3) +
                       " degrees from the slice normal; the volume is kept as a sheared grid");
  }
  if (worst > 0.02 * spacing) {
    warnings.push_back("slice distances vary by up to " + mm(worst) + "; " + mm(along) + " is used for all");
  }
  const double stated = first.slice_distance_mm.value_or(0);
  if (stated > 0 && std::abs(stated - along) > 0.02 * along) {
    warnings.push_back("the slices are " + mm(along) + " apart, but the header states " + mm(stated));
  }
  if (slices.size() < 3) {
    warnings.push_back("only " + counted(static_cast<std::int64_t>(slices.size()), "slice") +
                       ": a missing slice cannot be detected");
  }
}

}  // namespace simplexseg
