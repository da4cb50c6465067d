// SPDX-License-Identifier: Apache-2.0
// What lies under a position in a slice view.
#pragma once
#include <QPointF>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class SliceView;
class Workbench;

/// Nearest point whose handle or stroke is within 8 logical pixels; 0 if there is none.
ItemId point_in_slice(const Workbench& workbench, const SliceView& view, const QPointF& pixel);
/// Mesh with the nearest contour within 8 logical pixels, else a mesh that contains the position; 0 if there is none.
ItemId mesh_in_slice(Workbench& workbench, const SliceView& view, const QPointF& pixel);

/// Segments of a stroke near the slice, or of a lasso drawn in it, mm: start, end, start, end ...; none for a point.
std::vector<Eigen::Vector3f> lines_in_slice(const Workbench& workbench, const SliceView& view, const UserPoint& point);

double pixel_length(const QPointF& offset);
/// Distance from `p` to the segment from `a` to `b`, logical pixels.
double distance_to_segment(const QPointF& p, const QPointF& a, const QPointF& b);

}  // namespace simplexseg
