// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/simulation_rows.h"

#include <QGridLayout>
#include <QLabel>
#include <QScrollArea>
#include <QVBoxLayout>

#include "core/expect.h"
#include "gui/look/widgets.h"
#include "gui/panels/parameter_help.h"
#include "gui/panels/parameter_row.h"
#include "gui/workbench/workbench.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

SimulationRows::SimulationRows(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  auto* scroll = new QScrollArea(this);
  scroll->setWidgetResizable(true);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  auto* content = new QWidget(scroll);
  auto* grid = new QGridLayout(content);
  grid->setContentsMargins(0, 4, 6, 0);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(1, 1);
  const auto table = simulation_table();
  auto* help = new ParameterHelp(this);
  for (std::size_t p = 0; p < table.size(); ++p) {
    auto* label = new QLabel(words_of(table[p].name), content);
    label->setToolTip(QString::fromUtf8(table[p].doc));
    auto* row = new ParameterRow(table[p], content);
    connect(row, &ParameterRow::edited, this, [this, p](float value, bool continues) {
      if (!workbench_.apply(SetSimulationParameter{static_cast<int>(p), value, continues})) refresh();
    });
    grid->addWidget(label, static_cast<int>(p), 0);
    grid->addWidget(row, static_cast<int>(p), 1);
    help->watch(*row, words_of(table[p].name));
    rows_.push_back(row);
    labels_.push_back(label);
  }
  grid->setRowStretch(static_cast<int>(table.size()), 1);
  scroll->setWidget(content);
  layout->addWidget(scroll, 1);
  layout->addWidget(help);
  connect(&workbench_, &Workbench::scene_changed, this, &SimulationRows::refresh);
  refresh();
}

ParameterRow* SimulationRows::row(int parameter) const {
  SIMPLEXSEG_EXPECT(parameter >= 0 && parameter < static_cast<int>(rows_.size()));
  return rows_[parameter];
}

void SimulationRows::refresh() {
  const SimulationParameters& simulation = workbench_.scene().simulation;
  for (std::size_t p = 0; p < rows_.size(); ++p) {
    rows_[p]->set_value(value_of(simulation, static_cast<int>(p)));
    const bool is_used = has_effect(simulation, static_cast<int>(p));
    set_enabled(rows_[p], is_used,
                tr("Used only by the solver verlet; the other solvers choose this value themselves"));
    labels_[p]->setEnabled(is_used);
  }
}

}  // namespace simplexseg
