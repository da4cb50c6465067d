// SPDX-License-Identifier: Apache-2.0
#include "gui/views/layer_overlay.h"

#include <QMouseEvent>
#include <algorithm>
#include <cmath>
#include <utility>

#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/views/drawn_scene.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr double kReachOfDivider = 6;  // largest distance of a press from the divider, logical pixels
constexpr double kSquare = 56;         // side of a square of the checkerboard, logical pixels
}  // namespace

void LayerOverlay::prepare(const SceneBuffers::Slice* slice) {
  slices_.clear();
  const LandmarkInput& landmarks = workbench_.view.landmarks;
  const bool layer_only = landmarks.next == LandmarkInput::Next::Layer;
  if (!slice || !(workbench_.view.show_layers || layer_only) || workbench_.scene().layers.empty() ||
      landmarks.next == LandmarkInput::Next::Volume)
    return;
  if (const std::vector<LayerSlice>* const drawn = drawn_.layers(slice->grid, view_.orientation(), view_.neighbour()))
    slices_ = *drawn;
  if (layer_only) std::erase_if(slices_, [&](const LayerSlice& one) { return one.item.id != landmarks.layer; });
}

void LayerOverlay::draw(const Projection& projection) const {
  const auto ratio = static_cast<float>(view_.devicePixelRatio());
  LayerCover cover;
  cover.mode = workbench_.view.layer_mode;
  cover.divider_px = static_cast<float>(divider_x()) * ratio;
  cover.square_px = static_cast<float>(kSquare) * ratio;
  if (workbench_.view.landmarks.next == LandmarkInput::Next::Layer)
    cover.mode = LayerMode::Swipe, cover.divider_px = 0;  // covers the volume
  for (const LayerSlice& slice : slices_) painter_.draw(projection, slice, cover);
}

bool LayerOverlay::shows_divider() const {
  return !slices_.empty() && workbench_.view.layer_mode == LayerMode::Swipe &&
         workbench_.view.landmarks.next == LandmarkInput::Next::None;
}

double LayerOverlay::divider_x() const { return std::round(workbench_.view.swipe * view_.width()); }

void LayerOverlay::draw_divider(const Projection& projection) {
  if (!shows_divider()) return;
  const double x = divider_x();
  const auto ratio = static_cast<float>(view_.devicePixelRatio());
  const Eigen::Vector3f ends[] = {view_.world_of({x, 0}).cast<float>(),
                                  view_.world_of({x, static_cast<double>(view_.height())}).cast<float>()};
  lines_.draw(projection, ends, rgba_of(theme::kSliceBackground, 0.8f), 4 * ratio);
  lines_.draw(projection, ends, rgba_of(theme::kSelected), (is_on_divider() ? 3 : 2) * ratio);
  const DiscPainter::Disc handle{view_.world_of({x, view_.height() / 2.0}).cast<float>(), rgba_of(theme::kSelected),
                                 rgba_of(theme::kSliceBackground), (is_on_divider() ? 8 : 7) * ratio};
  discs_.draw(projection, {&handle, 1});
}

void LayerOverlay::add_labels(std::vector<Label>& labels, const QRectF& box) const {
  if (!shows_divider()) return;
  const double x = divider_x(), top = box.top() + 2.2 * view_.fontMetrics().lineSpacing();
  QStringList names;
  for (const LayerSlice& slice : slices_) names << text(slice.item.name);
  const QRectF left(box.left(), top, std::max(0.0, x - box.left() - 8), box.height()),
      right(x + 8, top, std::max(0.0, box.right() - x - 8), box.height());
  labels.push_back({left, Qt::AlignRight | Qt::AlignTop, SliceView::tr("volume"), theme::kText, false});
  labels.push_back({right, Qt::AlignLeft | Qt::AlignTop, names.join(", "), theme::kSelected, false});
}

void LayerOverlay::drag_contrast(const QPointF& moved) {
  const LayerItem* const layer = workbench_.scene().find_layer(workbench_.view.active_layer);
  if (!layer || moved.isNull()) return;
  // Same speed as for the volume: a vertical drag of 250 logical pixels changes the level by the width of the window.
  const double per_pixel = layer->window / 250;
  EditLayer edit{layer->id};
  edit.window = std::max(layer->window + moved.x() * per_pixel, 1e-9);
  edit.level = layer->level + moved.y() * per_pixel;
  edit.continues = std::exchange(contrast_set_, true);
  workbench_.apply(edit);
}

bool LayerOverlay::press(const QMouseEvent& event) {
  if (workbench_.view.layer_contrast_armed && event.button() == Qt::LeftButton && workbench_.has_volume()) {
    last_ = event.position();
    contrast_set_ = false;
    return sets_contrast_ = true;
  }
  if (!shows_divider() || event.button() != Qt::LeftButton || event.modifiers() != Qt::NoModifier ||
      workbench_.view.window_level_armed || std::abs(event.position().x() - divider_x()) > kReachOfDivider)
    return false;
  return dragged_ = true;
}

bool LayerOverlay::move(const QMouseEvent& event) {
  if (sets_contrast_) {
    drag_contrast(event.position() - std::exchange(last_, event.position()));
    return true;
  }
  if (dragged_) {
    workbench_.view.swipe = std::clamp(event.position().x() / std::max(view_.width(), 1), 0.0, 1.0);
    workbench_.view_edited();
    return true;
  }
  const bool on_divider = shows_divider() && event.buttons() == Qt::NoButton &&
                          std::abs(event.position().x() - divider_x()) <= kReachOfDivider;
  if (std::exchange(hovered_, on_divider) != on_divider) {
    view_.update_cursor();
    view_.update();
  }
  return false;
}

bool LayerOverlay::release(const QMouseEvent& event) {
  if (sets_contrast_ && event.button() == Qt::LeftButton) {
    sets_contrast_ = workbench_.view.layer_contrast_armed = false;
    workbench_.view_edited();
    return true;
  }
  if (!dragged_ || event.button() != Qt::LeftButton) return false;
  dragged_ = false;
  view_.update_cursor();
  view_.update();
  return true;
}

}  // namespace simplexseg
