// SPDX-License-Identifier: Apache-2.0
// Lines and handles of measurements in a slice, and how a drag of a handle changes the points.
#pragma once
#include <QPointF>
#include <optional>
#include <vector>

#include "image/measurement.h"
#include "session/scene.h"

namespace simplexseg {

class SliceView;
class Workbench;

/// Whether all points of a measurement are within half a slice of the view's slice.
bool lies_in_slice(const Workbench& workbench, const SliceView& view, const std::vector<Eigen::Vector3d>& points_mm);

/// Segments of a measurement, mm: start, end, start, end ... An angle has an arc between its legs.
std::vector<Eigen::Vector3f> lines_of(const Measurement& measurement);
/// Positions that a drag can move, mm: the points; of an ellipse, the centre and the four ends of its axes.
std::vector<Eigen::Vector3d> handles_of(const Measurement& measurement);
/// Points after a drag of a handle to a position. The centre of an ellipse moves the whole; an end of an axis turns and
/// scales the ellipse in its plane, whose other axis stays perpendicular and keeps its length.
std::vector<Eigen::Vector3d> with_moved_handle(const Measurement& measurement, std::size_t handle,
                                               const Eigen::Vector3d& to_mm);
/// Ellipse in the rectangle between two opposite corners, whose sides have these directions (unit vectors).
std::vector<Eigen::Vector3d> ellipse_in_rectangle(const Eigen::Vector3d& corner_mm, const Eigen::Vector3d& opposite_mm,
                                                  const Eigen::Vector3d& right, const Eigen::Vector3d& up);

/// Part of a measurement under a position in a slice view.
struct MeasurementHit {
  ItemId measurement;
  std::optional<std::size_t> handle;  ///< index in handles_of(); none: its line
};
/// Measurement whose handle is within 8 logical pixels, else one whose line is within 4; nullopt if there is none.
std::optional<MeasurementHit> measurement_in_slice(const Workbench& workbench, const SliceView& view,
                                                   const QPointF& pixel);

}  // namespace simplexseg
