// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPointF>

#include "gui/drawing/label_painter.h"
#include "gui/drawing/layer_painter.h"

class QMouseEvent;

namespace simplexseg {

class DrawnScene;
class SliceView;
class Workbench;

/// Layers of a slice view, the divider of a swipe, which the left button drags, and the drag that sets window and level
/// of the active layer (ViewState::layer_contrast_armed).
class LayerOverlay {
 public:
  LayerOverlay(Workbench& workbench, DrawnScene& drawn, SliceView& view)
      : workbench_(workbench), drawn_(drawn), view_(view) {}
  void create() { painter_.create(), lines_.create(), discs_.create(); }
  void destroy() { painter_.destroy(), lines_.destroy(), discs_.destroy(); }

  /// Updates the sections of the layers; `slice`: slice of the volume, null without one.
  void prepare(const SceneBuffers::Slice* slice);
  /// Draws the layers that prepare() has updated.
  void draw(const Projection& projection) const;
  /// Draws the divider of a swipe.
  void draw_divider(const Projection& projection);
  /// Adds the names of volume and layers on both sides of the divider of a swipe. `box`: place of texts.
  void add_labels(std::vector<Label>& labels, const QRectF& box) const;

  // Handlers of mouse events. Each returns true if this object uses the event.
  bool press(const QMouseEvent& event);
  bool move(const QMouseEvent& event);
  bool release(const QMouseEvent& event);
  /// Whether the mouse is on the divider or drags it.
  bool is_on_divider() const { return dragged_ || hovered_; }
  void leave() { hovered_ = false; }

 private:
  bool shows_divider() const;
  double divider_x() const;  ///< logical pixels
  void drag_contrast(const QPointF& moved);

  Workbench& workbench_;
  DrawnScene& drawn_;
  SliceView& view_;
  LayerPainter painter_;
  LinePainter lines_;
  DiscPainter discs_;
  std::vector<LayerSlice> slices_;
  bool hovered_ = false, dragged_ = false;
  QPointF last_;                                       ///< mouse position of a drag of window and level
  bool sets_contrast_ = false, contrast_set_ = false;  ///< such a drag is in progress, and has changed the layer
};

}  // namespace simplexseg
