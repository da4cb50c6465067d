// SPDX-License-Identifier: Apache-2.0
#include "gui/window/step_strip.h"

#include <QAction>
#include <QHBoxLayout>
#include <QToolButton>
#include <array>

#include "gui/input/action_table.h"
#include "gui/input/key_map.h"
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
  std::array<QAction*, 3> steps_actions{};
  for (int n = 0; n < 3; ++n) {
    QAction* action = steps_actions[n] = actions[steps[n].second];
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
  connect(&KeyMap::shared(), &KeyMap::changed, this, [this, steps_actions] {
    for (int n = 0; n < 3; ++n) steps_[n]->setToolTip(steps_actions[n]->toolTip());
    refresh();
  });
  refresh();
}

int StepStrip::step() const {
  if (!workbench_.has_volume()) return 0;
  return workbench_.scene().meshes.empty() || workbench_.view.tool == Tool::Seed ? 1 : 2;
}

QString StepStrip::hint() const {
  switch (step()) {
    case 0:
      return tr("Open a volume or a scene (%1), or drop a file or a DICOM folder on the window")
          .arg(key_hint(Act::Open));
    case 1:
      if (workbench_.view.tool == Tool::Seed)
        return tr("Drag in a slice from the centre of the structure to its edge; it grows when you release the button");
      return tr("Click on the structure in the slices, then choose the tool Seed (%1) and drag from its centre to its "
                "edge")
          .arg(key_hint(Act::ToolSeed));
    default:
      break;
  }
  QStringList keys;
  for (const auto& [act, effect] : {std::pair{Act::AddInside, tr("inside")},
                                    {Act::AddOutside, tr("outside")},
                                    {Act::ToolSeed, tr("another structure")},
                                    {Act::SaveLabels, tr("save labels")}})
    if (const QString key = key_text(act); !key.isEmpty()) keys << tr("%1: %2").arg(key, effect);
  return tr("Drag the contour where it is wrong. %1").arg(keys.join(", "));
}

void StepStrip::refresh() {
  for (int n = 0; n < 3; ++n) steps_[n]->setChecked(n == step());
  const QString text = hint();
  hint_->setToolTip(text);
  hint_->setText(text);
}

}  // namespace simplexseg
