// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "session/scene.h"

namespace simplexseg {

class Workbench;

/// Drag that draws a stroke for the active mesh: an inside or outside point if the mouse does not move, else a stroke.
class StrokeTool {
 public:
  explicit StrokeTool(Workbench& workbench) : workbench_(workbench) {}

  void begin(MarkKind kind, const Eigen::Vector3d& at_mm);
  /// Adds a vertex, unless it is nearer than half a voxel to the last one or outside the image.
  void extend(const Eigen::Vector3d& at_mm);
  /// Adds the stroke to the scene; a failure becomes a message.
  void finish();
  /// Stroke while the user draws it; otherwise none. Its radius is unknown.
  const std::optional<UserPoint>& stroke() const { return stroke_; }

 private:
  Workbench& workbench_;
  std::optional<UserPoint> stroke_;
};

}  // namespace simplexseg
