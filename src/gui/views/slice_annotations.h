// SPDX-License-Identifier: Apache-2.0
// Title and scale bar of a slice view.
#pragma once
#include <Eigen/Core>
#include <QString>
#include <vector>

namespace simplexseg {

class SliceView;
class Workbench;

/// Name, number and position of the slice, as far as they fit into the left half of the view.
QString slice_title(const Workbench& workbench, const SliceView& view);
/// Length of the scale bar, mm: 1, 2 or 5 times a power of ten, at most a fifth of the width of the view.
double scale_bar_mm(const SliceView& view);
/// Segments of the scale bar, mm: start, end, start, end ...
std::vector<Eigen::Vector3f> scale_bar_lines(const SliceView& view);

}  // namespace simplexseg
