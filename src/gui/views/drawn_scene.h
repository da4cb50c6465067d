// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <functional>

#include "gui/drawing/scene_buffers.h"
#include "gui/views/point_springs.h"

namespace simplexseg {

class Session;
class Workbench;

/// The scene as the views draw it: the OpenGL buffers that the four of them share, brought up to date from the session
/// while one of them paints. The window makes it and gives it to the views: were it in a view it would have to be
/// handed on when that view goes, and in the workbench the panels and the frame loop would know of OpenGL.
class DrawnScene : public QObject {
  Q_OBJECT
 public:
  explicit DrawnScene(Workbench& workbench);

  SceneBuffers& buffers() { return buffers_; }
  const SceneBuffers& buffers() const { return buffers_; }

  // For a view while it paints, with its context current. Null when nothing can be drawn any more, which becomes a
  // message; the next scene that is opened is tried again.

  /// The surfaces in the session's present pose.
  const SceneBuffers* surfaces();
  /// Whether the surfaces, brought up to date before, can be coloured by ViewState::surface_values.
  bool surface_values();
  /// Where the slice through the crosshair cuts the surfaces. There must be a volume.
  const SceneBuffers::Outlines* outlines(Orientation orientation);
  /// What boundary points pull, as far as it is known.
  const PointSprings& springs();
  /// The slice through the crosshair. There must be a volume.
  const SceneBuffers::Slice* slice(Orientation orientation);
  /// The field of the active mesh; null also while it is not shown, or there is none.
  const SceneBuffers::Field* field();

 signals:
  /// SceneBuffers::how() says something else than before.
  void manner_changed();

 private:
  void begin_volume();
  bool update_buffers(const std::function<void(Session&)>& update);

  Workbench& workbench_;
  SceneBuffers buffers_;
  PointSprings springs_;
  bool failed_ = false;
};

}  // namespace simplexseg
