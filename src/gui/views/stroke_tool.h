// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "session/scene.h"

namespace simplexseg {

class Workbench;

/// Drag that draws a stroke for the active mesh: paint, or a mark, which is a point if the mouse does not move; or the
/// contour from which a mesh starts.
class StrokeTool {
 public:
  explicit StrokeTool(Workbench& workbench) : workbench_(workbench) {}

  /// Begins a mark in a slice with this unit normal: a point, a stroke or, with ViewState::lasso, a lasso.
  void begin(MarkKind kind, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal);
  /// Begins paint in a slice with this unit normal, with tool and brush of the view state.
  void begin_paint(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal);
  /// Adds a vertex, unless it is nearer than half a voxel or a tenth of the brush to the last one, or outside the
  /// image.
  void extend(const Eigen::Vector3d& at_mm);
  /// Begins a contour around a new segmentation in a slice with this unit normal.
  void begin_start(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal);
  /// Adds the stroke to the scene, unless it is a lasso that encloses nothing; a failure becomes a message. Returns
  /// true if a segmentation was started.
  bool finish();
  /// Stroke while the user draws it; otherwise none. The radius of a mark is unknown. Without a mesh: the contour of a
  /// new segmentation.
  const std::optional<UserPoint>& stroke() const { return stroke_; }
  /// Changes the radius of the brush by a number of notches of the wheel, or parts of one.
  void resize_brush(double notches);

 private:
  bool start(const UserPoint& contour);

  Workbench& workbench_;
  std::optional<UserPoint> stroke_;  ///< with the edit of paint, but without its voxels
};

}  // namespace simplexseg
