// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <functional>
#include <optional>

#include "gui/drawing/scene_buffers.h"
#include "gui/views/point_springs.h"

namespace simplexseg {

class Session;
class Workbench;

/// Scene as drawn by the views: the OpenGL buffers that all four share, updated from the session while a view paints.
/// The window owns it: a view may be destroyed before the others, and the workbench must not depend on OpenGL.
class DrawnScene : public QObject {
  Q_OBJECT
 public:
  explicit DrawnScene(Workbench& workbench);

  SceneBuffers& buffers() { return buffers_; }
  const SceneBuffers& buffers() const { return buffers_; }

  // Called by a view while it paints, with its context current. A failure becomes a message; until the next scene is
  // opened, the functions then return null or false, and springs() returns its last result.

  /// Surfaces in the current pose of the session.
  const SceneBuffers* surfaces();
  /// Updates the values of ViewState::surface_values; call it after surfaces(). Returns false if there are no values.
  bool surface_values();
  /// Contours of the surfaces in the slice through the crosshair or a neighbour of it (slice_through_mm()). Needs a
  /// volume.
  const SceneBuffers::Outlines* outlines(Orientation orientation, int neighbour = 0);
  /// Boundary points and the vertices that they pull; empty while the positions are not read back.
  const PointSprings& springs();
  /// Such a slice. Needs a volume.
  const SceneBuffers::Slice* slice(Orientation orientation, int neighbour = 0);
  /// Slice in any other plane; without a grid, releases it and returns null. Needs a volume.
  const SceneBuffers::Slice* free_slice(const std::optional<SliceGrid>& grid);
  /// Sections of the visible layers whose files are loaded, in a slice on this grid.
  const std::vector<LayerSlice>* layers(const SliceGrid& grid, Orientation orientation, int neighbour);
  /// Field of the active mesh; null while no field is shown.
  const SceneBuffers::Field* field();

 signals:
  /// SceneBuffers::transfer_mode() has changed.
  void transfer_mode_changed();

 private:
  void begin_volume();
  bool update_buffers(const std::function<void(Session&)>& update);

  Workbench& workbench_;
  SceneBuffers buffers_;
  PointSprings springs_;
  bool failed_ = false;
};

}  // namespace simplexseg
