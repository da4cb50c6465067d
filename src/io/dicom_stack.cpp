// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_stack.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "core/error.h"
#include "core/expect.h"

namespace simplexseg {
namespace {

std::string mm(double length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g mm", length);
  return text;
}

}  // namespace

void require_one_stack(const std::vector<DicomSlice>& slices, const std::string& what) {
  SIMPLEXSEG_EXPECT(!slices.empty());
  const DicomSlice& first = slices.front();
  std::vector<std::string> unplaced, sizes, orientations;
  for (const DicomSlice& s : slices) {
    if (!s.position || !s.axes) unplaced.push_back(name_of(s));
    if (s.pixels.rows != first.pixels.rows || s.pixels.columns != first.pixels.columns ||
        s.spacing_mm.has_value() != first.spacing_mm.has_value() ||
        (s.spacing_mm && !s.spacing_mm->isApprox(*first.spacing_mm, 1e-3))) {
      sizes.push_back(name_of(s));
    }
    if (s.axes && first.axes && (*s.axes - *first.axes).cwiseAbs().maxCoeff() > 1e-3)
      orientations.push_back(name_of(s));
  }
  if (!orientations.empty()) {
    throw Error("cannot read " + what,
                "its slices have different orientations: " + list_of(orientations) + " differ from " + name_of(first),
                "put slices of one orientation into a folder of their own");
  }
  if (!sizes.empty()) {
    throw Error(
        "cannot read " + what,
        "its slices have different sizes or pixel spacings: " + list_of(sizes) + " differ from " + name_of(first),
        "put slices of one size into a folder of their own");
  }
  if (!unplaced.empty()) {
    throw Error("cannot read " + what, "these slices have no position or orientation: " + list_of(unplaced),
                "export the series again with its image positions");
  }
}

void stack(std::vector<DicomSlice>& slices, VolumeGeometry& geometry, std::vector<std::string>& warnings,
           const std::string& what) {
  SIMPLEXSEG_EXPECT(!slices.empty() && slices.front().axes && slices.front().position);
  const Eigen::Vector3d normal = slices.front().axes->col(0).cross(slices.front().axes->col(1)).normalized();
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return std::tuple(place(a), a.file, a.frame) < std::tuple(place(b), b.file, b.frame);
  });
  constexpr double same_mm = 0.01;
  std::vector<double> gaps;
  std::vector<std::string> doubled, missing, uneven;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double gap = place(slices[i]) - place(slices[i - 1]);
    if (gap > same_mm)
      gaps.push_back(gap);
    else
      doubled.push_back(name_of(slices[i - 1]) + " and " + name_of(slices[i]));
  }
  double spacing = 0;
  if (!gaps.empty()) {
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + (sorted.size() - 1) / 2, sorted.end());
    spacing = sorted[(sorted.size() - 1) / 2];
  }
  double worst = 0;
  int lacking = 0;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const double gap = place(slices[i]) - place(slices[i - 1]);
    if (gap <= same_mm) continue;
    const double ratio = gap / spacing;
    const int places = static_cast<int>(std::lround(std::min(ratio, 1e6)));
    const std::string between = name_of(slices[i - 1]) + " and " + name_of(slices[i]);
    if (places >= 2 && std::abs(ratio - places) < 0.1 * places) {
      missing.push_back(std::to_string(places - 1) + " between " + between);
      lacking += places - 1;
    } else if (std::abs(ratio - 1) > 0.1) {
      uneven.push_back(mm(gap) + " between " + between);
    } else {
      worst = std::max(worst, std::abs(gap - spacing));
    }
  }
  if (!doubled.empty() || !missing.empty() || !uneven.empty()) {
    std::string why, todo;
    const auto add = [](std::string& to, const std::string& text) { to += (to.empty() ? "" : ", ") + text; };
    if (!missing.empty()) add(why, std::to_string(lacking) + " missing slice(s) (" + list_of(missing) + ")");
    if (!doubled.empty()) add(why, std::to_string(doubled.size()) + " doubled slice(s) (" + list_of(doubled) + ")");
    if (!uneven.empty()) add(why, "uneven slice distances (" + list_of(uneven) + " instead of " + mm(spacing) + ")");
    if (!missing.empty()) add(todo, "add the missing files");
    if (!doubled.empty()) add(todo, "leave one file for each position");
    if (!uneven.empty()) add(todo, "put each stack of evenly spaced slices into a folder of its own");
    throw Error("cannot read " + what, why, todo);
  }
  const DicomSlice& first = slices.front();
  geometry.origin_mm = *first.position;
  geometry.direction.leftCols<2>() = *first.axes;
  geometry.direction.col(2) = normal;
  if (slices.size() == 1) return;

  const double count = double(slices.size() - 1);
  const Eigen::Vector3d shift = (*slices.back().position - *first.position) / count;
  const double along = normal.dot(shift), lean = (shift - along * normal).norm() / along;
  double off_line = 0;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const Eigen::Vector3d off = *slices[i].position - *first.position - double(i) * shift;
    off_line = std::max(off_line, (off - normal.dot(off) * normal).norm());
  }
  const double pixel = first.spacing_mm ? first.spacing_mm->minCoeff() : 1;
  if (off_line > 0.5 * pixel) {
    throw Error("cannot read " + what, "its slices are shifted against each other by up to " + mm(off_line),
                "export the series again, or put each stack into a folder of its own");
  }
  if (off_line > 0.1 * pixel) warnings.push_back("slices lie up to " + mm(off_line) + " beside a straight stack");
  // A lean of rounding's size is none; a real one (tilted gantry) is kept as it is: the grid is sheared.
  geometry.spacing_mm[2] = lean < 1e-4 ? along : shift.norm();
  if (lean >= 1e-4) geometry.direction.col(2) = shift.normalized();
  if (lean > 1e-3) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "tilted gantry: the slices are stacked %.3g degrees off their normal; the volume is "
                  "kept as it was taken (a sheared grid)",
                  std::atan(lean) * 180 / M_PI);
    warnings.push_back(text);
  }
  if (worst > 0.02 * spacing) {
    warnings.push_back("slice distances vary by up to " + mm(worst) + "; " + mm(along) + " is taken for all");
  }
  if (first.between_mm && *first.between_mm > 0 && std::abs(*first.between_mm - along) > 0.02 * along) {
    warnings.push_back("slices lie " + mm(along) + " apart, though the header says " + mm(*first.between_mm));
  }
  if (slices.size() < 3) {
    warnings.push_back("only " + std::to_string(slices.size()) + " slices: a missing one would not be noticed");
  }
}

}  // namespace simplexseg
