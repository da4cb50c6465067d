// SPDX-License-Identifier: Apache-2.0
#include "gui/window/step_strip.h"

#include <QAction>
#include <QHBoxLayout>
#include <QToolButton>

#include "gui/input/action_table.h"
#include "gui/look/elided_label.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

StepStrip::StepStrip(Workbench& workbench, ActionTable& actions, QWidget* parent)
    : QFrame(parent), workbench_(workbench) {
  setObjectName("step_strip");
  setFixedHeight(fontMetrics().height() + 14);
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(8, 2, 8, 2);
  row->setSpacing(4);
  const std::pair<QString, Act> steps[] = {
      {tr("1  Open"), Act::Open}, {tr("2  Seed"), Act::ToolSeed}, {tr("3  Correct"), Act::ToolCrosshair}};
  for (int n = 0; n < 3; ++n) {
    QAction* action = actions[steps[n].second];
    steps_[n] = new QToolButton(this);
    steps_[n]->setText(steps[n].first);
    steps_[n]->setToolTip(action->toolTip());
    steps_[n]->setCheckable(true);
    connect(steps_[n], &QToolButton::clicked, this, [this, action] {
      action->trigger();
      refresh();  // a click checks the button, but does not change the step
    });
    row->addWidget(steps_[n]);
  }
  row->addSpacing(10);
  hint_ = new ElidedLabel(this);
  hint_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  row->addWidget(hint_, 1);
  connect(&workbench_, &Workbench::scene_changed, this, &StepStrip::refresh);
  connect(&workbench_, &Workbench::view_changed, this, &StepStrip::refresh);
  connect(&workbench_, &Workbench::volume_changed, this, &StepStrip::refresh);
  refresh();
}

int StepStrip::step() const {
  if (!workbench_.has_volume()) return 0;
  return workbench_.scene().meshes.empty() || workbench_.view.tool == Tool::Seed ? 1 : 2;
}

QString StepStrip::hint() const {
  switch (step()) {
    case 0:
      return tr("Press Ctrl+O to open a volume or a scene, or drop a file or a DICOM folder on the window");
    case 1:
      if (workbench_.view.tool == Tool::Seed)
        return tr("Drag in a slice from the centre of the structure to its edge; it grows when you release the button");
      return tr("Click on the structure in the slices, then press 4 and drag from its centre to its edge");
    default:
      break;
  }
  return tr("Drag the contour where it is wrong. I: inside, O: outside, 4: another structure, Ctrl+L: save labels");
}

void StepStrip::refresh() {
  for (int n = 0; n < 3; ++n) steps_[n]->setChecked(n == step());
  const QString text = hint();
  hint_->setToolTip(text);
  hint_->setText(text);
}

}  // namespace simplexseg
