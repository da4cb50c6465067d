// SPDX-License-Identifier: Apache-2.0
#include "gui/window/status_line.h"

#include <QLabel>
#include <algorithm>
#include <cmath>

#include "gui/look/elided_label.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/views/drawn_scene.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

StatusLine::StatusLine(Workbench& workbench, DrawnScene& drawn, QWidget* parent)
    : QStatusBar(parent),
      workbench_(workbench),
      drawn_(drawn),
      place_(new QLabel(this)),
      learning_(new QLabel(this)),
      manner_(new ElidedLabel(this)),
      contrast_(new QLabel(this)) {
  setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);  // a long line must not widen the window
  setSizeGripEnabled(false);
  for (QLabel* label : {place_, learning_, manner_, contrast_}) label->setContentsMargins(8, 0, 8, 0);
  place_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  set_role(manner_, "dim");
  addWidget(place_, 1);
  set_role(learning_, "warning");
  learned_.setSingleShot(true);
  learned_.setInterval(300);
  connect(&learned_, &QTimer::timeout, learning_, &QLabel::clear);
  addPermanentWidget(learning_);
  addPermanentWidget(manner_);
  addPermanentWidget(contrast_);
  connect(&workbench_, &Workbench::view_changed, this, &StatusLine::refresh_view);
  connect(&workbench_, &Workbench::learning_changed, this, &StatusLine::refresh_learning);
  connect(&workbench_, &Workbench::running_changed, this, &StatusLine::refresh_learning);
  connect(&drawn_, &DrawnScene::manner_changed, this, &StatusLine::refresh_manner);
  refresh_view();
}

void StatusLine::refresh_view() {
  if (!workbench_.has_volume()) {
    place_->setText(tr("No volume"));
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
  place_->setText(tr("LPS  %1  %2  %3 mm      voxel  %4  %5  %6      intensity  %7")
                      .arg(view.crosshair_mm.x(), 0, 'f', 1)
                      .arg(view.crosshair_mm.y(), 0, 'f', 1)
                      .arg(view.crosshair_mm.z(), 0, 'f', 1)
                      .arg(voxel[0])
                      .arg(voxel[1])
                      .arg(voxel[2])
                      .arg(volume.value(voxel[0], voxel[1], voxel[2]), 0, 'g', 6));
  contrast_->setText(tr("window %1  level %2").arg(view.window, 0, 'g', 4).arg(view.level, 0, 'g', 4));
}

// While the simulation is paused nothing is learned.
void StatusLine::refresh_learning() {
  const MeshItem* item = workbench_.running() ? workbench_.scene().find_mesh(workbench_.session().learning()) : nullptr;
  if (!item) {
    learned_.start();
    return;
  }
  learned_.stop();
  learning_->setText(tr("learning mesh '%1'").arg(QString::fromStdString(item->name)));
}

void StatusLine::refresh_manner() {
  const SceneBuffers& buffers = drawn_.buffers();
  manner_->setText(QString::fromStdString(buffers.renderer()) + ": " +
                   (buffers.on_device() ? tr("drawn on the device") : tr("uploaded each frame")));
  manner_->setToolTip(QString::fromStdString(buffers.how()));
}

}  // namespace simplexseg
