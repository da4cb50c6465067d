// SPDX-License-Identifier: Apache-2.0
#include "gui/window/status_line.h"

#include <QLabel>
#include <algorithm>
#include <cmath>

#include "gui/look/elided_label.h"
#include "gui/look/qt_text.h"
#include "gui/look/slice_geometry.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/views/drawn_scene.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

StatusLine::StatusLine(Workbench& workbench, DrawnScene& drawn, QWidget* parent)
    : QStatusBar(parent),
      workbench_(workbench),
      drawn_(drawn),
      position_(new QLabel(this)),
      solving_(new QLabel(this)),
      renderer_(new ElidedLabel(this)),
      contrast_(new QLabel(this)) {
  setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);  // a long line must not widen the window
  setSizeGripEnabled(false);
  for (QLabel* label : {position_, solving_, renderer_, contrast_}) label->setContentsMargins(8, 0, 8, 0);
  position_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  set_role(renderer_, "dim");
  addWidget(position_, 1);
  set_role(solving_, "warning");
  clear_timer_.setSingleShot(true);
  clear_timer_.setInterval(300);
  connect(&clear_timer_, &QTimer::timeout, solving_, &QLabel::clear);
  addPermanentWidget(solving_);
  addPermanentWidget(renderer_);
  addPermanentWidget(contrast_);
  connect(&workbench_, &Workbench::view_changed, this, &StatusLine::refresh_view);
  connect(&workbench_, &Workbench::solving_changed, this, &StatusLine::refresh_solving);
  connect(&workbench_, &Workbench::solving_progressed, this, &StatusLine::refresh_solving);
  connect(&workbench_, &Workbench::running_changed, this, &StatusLine::refresh_solving);
  connect(&drawn_, &DrawnScene::transfer_mode_changed, this, &StatusLine::refresh_renderer);
  refresh_view();
}

void StatusLine::refresh_view() {
  if (!workbench_.has_volume()) {
    positions_ = {tr("No volume")};
    show_position();
    contrast_->clear();
    return;
  }
  const ViewState& view = workbench_.view;
  const Volume& volume = workbench_.session().volume();
  const Eigen::Vector3d index = volume.geometry().index_from_world() * view.crosshair_mm;
  int voxel[3];
  for (int axis = 0; axis < 3; ++axis) {
    voxel[axis] = std::clamp(static_cast<int>(std::lround(index[axis])), 0, volume.geometry().size[axis] - 1);
  }
  const int decimals = position_decimals(volume.geometry());
  const QString position = tr("LPS  %1  %2  %3 mm")
                               .arg(view.crosshair_mm.x(), 0, 'f', decimals)
                               .arg(view.crosshair_mm.y(), 0, 'f', decimals)
                               .arg(view.crosshair_mm.z(), 0, 'f', decimals);
  const QString voxels = tr("voxel  %1  %2  %3").arg(voxel[0]).arg(voxel[1]).arg(voxel[2]);
  const QString intensity = tr("intensity  %1").arg(volume.value(voxel[0], voxel[1], voxel[2]), 0, 'g', 6);
  const QString gap = "      ";
  QString layers;
  for (const LayerItem& layer : workbench_.scene().layers) {
    const std::optional<double> value = workbench_.layer_images().value_at(layer, view.crosshair_mm);
    if (!layer.visible || !view.show_layers) continue;
    layers += gap + text(layer.name) + "  " + (value ? QString::number(*value, 'g', 6) : QString("-"));
    if (value && !layer.unit.empty()) layers += " " + text(layer.unit);
  }
  const QString values = intensity + layers;
  positions_ = {position + gap + voxels + gap + values, position + gap + values, values, position};
  if (layers.isEmpty()) positions_.removeAt(2);
  contrast_->setText(tr("window %1  level %2").arg(view.window, 0, 'g', 4).arg(view.level, 0, 'g', 4));
  show_position();
}

void StatusLine::show_position() {
  if (positions_.isEmpty()) return;
  int available = width();
  for (const QLabel* label : {solving_, contrast_}) available -= label->sizeHint().width();
  constexpr int kMargins = 24;
  const auto fits = [&](const QString& text) {
    return position_->fontMetrics().horizontalAdvance(text) + kMargins <= available;
  };
  const auto shown = std::find_if(positions_.begin(), positions_.end() - 1, fits);
  position_->setText(*shown);
  position_->setToolTip(shown == positions_.begin() ? QString() : positions_.front());
}

void StatusLine::resizeEvent(QResizeEvent* event) {
  QStatusBar::resizeEvent(event);
  show_position();
}

// Shows no mesh while the simulation is paused.
void StatusLine::refresh_solving() {
  const MeshItem* item =
      workbench_.running() ? workbench_.scene().find_mesh(workbench_.session().solving_mesh()) : nullptr;
  if (!item) {
    clear_timer_.start();
    return;
  }
  clear_timer_.stop();
  solving_->setText(
      tr("solving '%1' %2%").arg(QString::fromStdString(item->name), QString::number(workbench_.solving_percent())));
}

void StatusLine::refresh_renderer() {
  const SceneBuffers& buffers = drawn_.buffers();
  renderer_->setText(QString::fromStdString(buffers.renderer()) + ": " +
                     (buffers.on_device() ? tr("drawn from device memory") : tr("uploaded each frame")));
  renderer_->setToolTip(QString::fromStdString(buffers.transfer_mode()));
}

}  // namespace simplexseg
