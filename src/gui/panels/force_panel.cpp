// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/force_panel.h"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QScrollArea>
#include <QScrollBar>
#include <QSignalBlocker>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>

#include "core/expect.h"
#include "gui/input/key_map.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/parameter_help.h"
#include "gui/panels/parameter_row.h"
#include "gui/panels/preset_menu.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

ForcePanel::ForcePanel(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 4, 4);
  layout->setSpacing(4);
  auto* head = new QHBoxLayout;
  title_ = new QLabel(this);
  all_meshes_ = new QCheckBox(tr("Apply to all"), this);
  all_meshes_->setToolTip(tr("Apply changes to all segmentations"));
  presets_ = new QToolButton(this);
  presets_->setText(tr("Presets"));
  presets_->setToolTip(tr("Settings of all forces and of the simulation: defaults, saved presets, files"));
  presets_->setPopupMode(QToolButton::InstantPopup);
  presets_->setFocusPolicy(Qt::StrongFocus);
  set_role(presets_, "raised");
  const auto target = [this] { return all_meshes_->isChecked() ? 0 : workbench_.view.active_mesh; };
  presets_->setMenu(new PresetMenu(workbench_, target, presets_));
  head->addWidget(title_, 1);
  head->addWidget(all_meshes_);
  head->addWidget(presets_);
  layout->addLayout(head);
  help_ = new ParameterHelp(this);

  auto* scroll = new QScrollArea(this);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  sections_widget_ = new QWidget(scroll);
  auto* sections_layout = new QVBoxLayout(sections_widget_);
  sections_layout->setContentsMargins(0, 0, 6, 0);
  sections_layout->setSpacing(2);
  sections_.reserve(force_list().size());  // no reallocation while sections are added
  for (const ForceInfo& force : force_list()) sections_.push_back(build_section(force));
  sections_layout->addStretch(1);
  scroll->setWidget(sections_widget_);
  // The panel is wide enough for the contents and the scroll bar.
  int widest = sections_widget_->minimumSizeHint().width();
  for (const Section& section : sections_) widest = std::max(widest, section.details->minimumSizeHint().width() + 6);
  scroll->setMinimumWidth(widest + scroll->verticalScrollBar()->sizeHint().width());
  layout->addWidget(scroll, 1);
  layout->addWidget(help_);

  connect(&workbench_, &Workbench::scene_changed, this, &ForcePanel::refresh);
  refresh();
}

ForcePanel::Section ForcePanel::build_section(const ForceInfo& force) {
  const std::size_t index = sections_.size();
  Section section{&force, nullptr, nullptr, nullptr, {}};
  const QString doc = QString::fromUtf8(force.doc);
  section.unfold = new QToolButton(sections_widget_);
  section.unfold->setArrowType(Qt::RightArrow);
  section.unfold->setAutoRaise(true);
  set_role(section.unfold, "flat");
  section.unfold->setToolTip(tr("Show the parameters"));
  section.unfold->setAccessibleName(tr("Parameters of %1").arg(QString::fromUtf8(force.title)));
  section.unfold->setFocusPolicy(Qt::StrongFocus);
  section.on = new QCheckBox(QString::fromUtf8(force.title), sections_widget_);
  section.on->setToolTip(doc);
  auto* head = new QHBoxLayout;
  head->setSpacing(4);
  head->addWidget(section.unfold);
  head->addWidget(section.on, 1);
  section.details = new QWidget(sections_widget_);
  section.details->setVisible(false);
  auto* grid = new QGridLayout(section.details);
  grid->setContentsMargins(26, 0, 0, 6);
  grid->setHorizontalSpacing(8);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(1, 1);
  for (std::size_t p = 0; p < force.parameters.size(); ++p) {
    auto* row = new ParameterRow(force.parameters[p], sections_widget_);
    section.rows.push_back(row);
    connect(row, &ParameterRow::edited, this, [this, index, p](float value, bool continues) {
      set_parameter(sections_[index], static_cast<int>(p), value, continues);
    });
    const QString title = words_of(force.parameters[p].name);
    row->set_accessible_title(tr("%1, %2").arg(QString::fromUtf8(force.title), title));
    help_->watch(*row, tr("%1, %2").arg(QString::fromUtf8(force.title), title));
    if (p == 0) {
      // The weight stays visible beside the switch.
      row->setFixedWidth(theme::scaled(200));
      row->number()->setFixedWidth(theme::scaled(84));
      head->addWidget(row);
      continue;
    }
    auto* label = new QLabel(title, section.details);
    label->setToolTip(QString::fromUtf8(force.parameters[p].doc));
    grid->addWidget(label, static_cast<int>(p), 0);
    grid->addWidget(row, static_cast<int>(p), 1);
  }
  auto* layout = static_cast<QVBoxLayout*>(sections_widget_->layout());
  layout->addLayout(head);
  layout->addWidget(section.details);
  connect(section.unfold, &QToolButton::clicked, this, [unfold = section.unfold, details = section.details] {
    const bool show = details->isHidden();
    details->setVisible(show);
    unfold->setArrowType(show ? Qt::DownArrow : Qt::RightArrow);
  });
  // Connected to clicked(), because refresh() also toggles the switch.
  connect(section.on, &QCheckBox::clicked, this, [this, index](bool on) { switch_force(sections_[index], on); });
  return section;
}

ParameterRow* ForcePanel::row(ForceId force, int parameter) const {
  const std::vector<ParameterRow*>& rows = sections_[static_cast<int>(force)].rows;
  SIMPLEXSEG_EXPECT(parameter >= 0 && parameter < static_cast<int>(rows.size()));
  return rows[parameter];
}

void ForcePanel::refresh() {
  const MeshItem* mesh = workbench_.active_mesh();
  title_->setText(mesh ? tr("Forces on <b>%1</b>").arg(QString::fromStdString(mesh->name).toHtmlEscaped())
                       : tr("Forces"));
  const QString why = tr("There is no segmentation yet: add one in the panel Segmentations, or with the tool Seed (%1)")
                          .arg(key_hint(Act::ToolSeed));
  set_enabled(all_meshes_, mesh, why);
  for (Section& section : sections_) {
    const ForceParameters& parameters = mesh ? mesh->parameters : workbench_.scene().forces;
    const float* values = parameters.values[static_cast<int>(section.force->id)];
    const bool on = mesh && values[0] > 0;
    // A force that already has a weight stays enabled, so that it can be switched off.
    const bool lacks_profiles = mesh && !on && section.force->id == ForceId::IntensityProfile && mesh->profiles.empty();
    const QString why_not =
        mesh ? tr("No profiles recorded yet: choose Record profiles in the menu of the segmentation") : why;
    {
      const QSignalBlocker blocker(section.on);
      section.on->setChecked(on);
    }
    set_enabled(section.on, mesh && !lacks_profiles, why_not);
    for (std::size_t p = 0; p < section.rows.size(); ++p) {
      section.rows[p]->set_value(values[p]);
      set_enabled(section.rows[p], mesh && !(lacks_profiles && p == 0), why_not);
    }
    if (on) last_weight_[{mesh->id, section.force->id}] = values[0];
  }
}

void ForcePanel::set_parameter(const Section& section, int parameter, float value, bool continues) {
  if (!workbench_.active_mesh()) return;
  const ItemId mesh = all_meshes_->isChecked() ? 0 : workbench_.view.active_mesh;
  if (!workbench_.apply(SetForceParameter{mesh, section.force->id, parameter, value, continues})) refresh();
}

void ForcePanel::switch_force(const Section& section, bool on) {
  float weight = 0;
  if (on) {
    const float standard = section.force->parameters[0].default_value;
    const auto last = last_weight_.find({workbench_.view.active_mesh, section.force->id});
    weight = standard > 0 ? standard : std::min(1.0f, section.force->parameters[0].maximum);
    if (last != last_weight_.end()) weight = last->second;
  }
  set_parameter(section, 0, weight, false);
}

}  // namespace simplexseg
