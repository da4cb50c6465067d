// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/check_panel.h"

#include <QAbstractButton>
#include <QAction>
#include <QComboBox>
#include <QFileInfo>
#include <QGridLayout>
#include <QHeaderView>
#include <QLabel>
#include <QMenu>
#include <QPushButton>
#include <QTableWidget>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

#include "core/number_text.h"
#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/panels/measurement_list.h"
#include "gui/workbench/ask_and_save.h"
#include "gui/workbench/mesh_checker.h"
#include "gui/workbench/workbench.h"
#include "image/measurement.h"
#include "io/labels/label_mesh.h"
#include "io/platform/atomic_file.h"
#include "session/run_trace.h"

namespace simplexseg {
namespace {

enum Row { kVolume, kArea, kLongAxis, kShortAxis, kMean, kDeviation, kReference, kDice, kHd95, kAssd, kRows };

QString text_of_label(const Reference& reference) {
  const QString file = QFileInfo(QString::fromStdString(reference.labels)).fileName();
  return reference.value ? QString("%1  (%2)").arg(*reference.value, 0, 'g', 10).arg(file) : file;
}

QString number(double value, int decimals) {
  return std::isfinite(value) ? QString::number(value, 'f', decimals) : CheckPanel::tr("none");
}

/// Area with a unit in which it does not round to 0.
QString area_text(double cm2) {
  if (cm2 == 0 || cm2 >= 0.1) return CheckPanel::tr("%1 cm\u00b2").arg(cm2, 0, 'f', cm2 < 10 ? 2 : 1);
  return CheckPanel::tr("%1 mm\u00b2").arg(100 * cm2, 0, 'g', 3);
}
/// Length with a unit in which it does not round to 0; "none" for an undefined distance.
QString length(double mm) { return std::isfinite(mm) ? text(length_text(mm)) : CheckPanel::tr("none"); }

}  // namespace

CheckPanel::CheckPanel(Workbench& workbench, ActionTable& actions, QWidget* parent)
    : QWidget(parent),
      workbench_(workbench),
      checker_(new MeshChecker(workbench, this)),
      table_(new QTableWidget(kRows, 0, this)),
      empty_(new QLabel(this)),
      colours_(new QComboBox(this)),
      save_(new QPushButton(tr("Save table..."), this)) {
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(8, 6, 8, 6);
  column->setSpacing(6);
  const std::pair<QString, QString> rows[kRows] = {
      {tr("Volume"), tr("Volume inside the surface")},
      {tr("Area"), tr("Area of the surface")},
      {tr("Long axis"), tr("Longest diameter in an axial slice (RECIST 1.1); click a cell to go to that slice")},
      {tr("Short axis"), tr("Longest diameter perpendicular to the long axis, in the same slice (RECIST 1.1)")},
      {tr("Mean inside"), tr("Mean intensity of the voxels inside")},
      {tr("SD inside"), tr("Standard deviation of the intensities of the voxels inside")},
      {tr("Reference"), tr("Label with which the segmentation is compared; click a cell to choose one")},
      {tr("Dice"), tr("Overlap with the reference: 1 = identical, 0 = no overlap")},
      {tr("HD95"),
       tr("95th percentile of the distances between the two surfaces; the larger value of both directions")},
      {tr("ASSD"), tr("Mean distance between the two surfaces, over both directions")}};
  for (int row = 0; row < kRows; ++row) {
    auto* head = new QTableWidgetItem(rows[row].first);
    head->setToolTip(rows[row].second);
    table_->setVerticalHeaderItem(row, head);
  }
  table_->setAccessibleName(tr("Measurements"));
  make_read_only(*table_);
  table_->setSelectionMode(QAbstractItemView::NoSelection);
  table_->verticalHeader()->setSectionResizeMode(QHeaderView::Fixed);
  table_->verticalHeader()->setDefaultSectionSize(table_->fontMetrics().height() + 8);
  table_->horizontalHeader()->setDefaultSectionSize(84);
  table_->horizontalHeader()->setMinimumSectionSize(60);
  table_->horizontalHeader()->setDefaultAlignment(Qt::AlignLeft | Qt::AlignVCenter);
  table_->horizontalHeader()->setTextElideMode(Qt::ElideRight);
  table_->setMinimumHeight(80);
  column->addWidget(table_, 1);
  empty_->setWordWrap(true);
  set_role(empty_, "dim");
  column->addWidget(empty_);

  column->addWidget(new MeasurementList(workbench_, this));

  auto* buttons = new QGridLayout;
  buttons->setSpacing(6);
  auto* load = new QToolButton(this);
  load->setDefaultAction(actions[Act::OpenReference]);
  actions[Act::OpenReference]->setIconText(tr("Reference..."));
  load->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  auto* worst = new QToolButton(this);
  worst->setObjectName("worst_fit");
  worst->setDefaultAction(actions[Act::WorstFit]);
  actions[Act::WorstFit]->setIconText(tr("Worst fit"));
  worst->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  colours_->addItems(
      {tr("Colour of each segmentation"), tr("Colour by distance to the reference"), tr("Colour by fit to the image")});
  colours_->setAccessibleName(tr("Colours in the 3D view"));
  colours_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  colours_->setToolTip(
      tr("Colours in the 3D view. Fit: distance to the strongest image edge along the surface normal"));
  for (QToolButton* button : {load, worst}) set_role(button, "raised");
  buttons->addWidget(colours_, 0, 0, 1, 3);
  buttons->addWidget(load, 1, 0);
  buttons->addWidget(worst, 1, 1);
  buttons->addWidget(save_, 1, 2);
  column->addLayout(buttons);

  connect(colours_, &QComboBox::currentIndexChanged, this,
          [this](int index) { checker_->set_colours(static_cast<MeshChecker::Colours>(index)); });
  connect(save_, &QPushButton::clicked, this, &CheckPanel::choose_and_save);
  connect(table_, &QTableWidget::cellClicked, this, [this](int row, int mesh) {
    const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
    if (mesh >= static_cast<int>(meshes.size())) return;
    if (row == kReference)
      choose_reference(meshes[static_cast<std::size_t>(mesh)].id);
    else
      workbench_.set_active_mesh(meshes[static_cast<std::size_t>(mesh)].id);
    if (row == kLongAxis || row == kShortAxis) go_to_axes(meshes[static_cast<std::size_t>(mesh)].id);
  });
  actions.on(Act::WorstFit, [this] { checker_->go_to_worst(); });
  connect(checker_, &MeshChecker::checked, this, &CheckPanel::refresh);
  connect(&workbench_, &Workbench::scene_changed, this, &CheckPanel::refresh);
  connect(&workbench_, &Workbench::references_changed, this, &CheckPanel::refresh);
  refresh();
}

void CheckPanel::set_on_screen(bool on_screen) { checker_->set_watched(on_screen); }

void CheckPanel::fill_column(int column, const MeshItem& item) {
  const MeshCheck* check = checker_->of(item.id);
  const bool has_reference = workbench_.references().has(item);
  QString texts[kRows];
  if (check) {
    texts[kVolume] = text(volume_text(1000 * check->volume_ml));
    texts[kArea] = area_text(check->area_cm2);
    if (check->axes) {
      texts[kLongAxis] = text(measured_length_text(check->axes->long_mm()));
      texts[kShortAxis] = text(measured_length_text(check->axes->short_mm()));
    }
    if (check->inside) {
      texts[kMean] = QString::number(check->inside->mean, 'g', 5);
      texts[kDeviation] = QString::number(check->inside->deviation, 'g', 4);
    }
    if (check->agreement) {
      texts[kDice] = number(check->agreement->dice, 3);
      texts[kHd95] = length(check->agreement->hd95_mm);
      texts[kAssd] = length(check->agreement->assd_mm);
    }
  }
  texts[kReference] = has_reference ? text_of_label(*item.reference) : tr("none");
  auto* head = new QTableWidgetItem(swatch(item.colour), QString::fromStdString(item.name));
  head->setToolTip(QString::fromStdString(item.name));
  table_->setHorizontalHeaderItem(column, head);
  for (int row = 0; row < kRows; ++row) {
    auto* cell = new QTableWidgetItem(texts[row]);
    cell->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
    if ((row == kLongAxis || row == kShortAxis) && check && check->axes)
      cell->setToolTip(tr("In axial slice %1. Click to go there.").arg(check->axes->slice));
    if (row == kReference) {
      cell->setToolTip(tr("%1. Click to choose a reference.").arg(texts[row]));
      cell->setForeground(theme::shades().accent);
    }
    table_->setItem(row, column, cell);
  }
}

void CheckPanel::go_to_axes(ItemId mesh) {
  const MeshCheck* check = checker_->of(mesh);
  if (!check || !check->axes) return;
  workbench_.view.show_axes = true;
  workbench_.set_crosshair((check->axes->long_ends_mm[0] + check->axes->long_ends_mm[1]) / 2);
}

void CheckPanel::refresh() {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  table_->setColumnCount(static_cast<int>(meshes.size()));
  constexpr std::size_t kFitting = 3;  // number of columns that fit without scrolling
  table_->horizontalHeader()->setSectionResizeMode(meshes.size() <= kFitting ? QHeaderView::Stretch
                                                                             : QHeaderView::Interactive);
  for (std::size_t m = 0; m < meshes.size(); ++m) fill_column(static_cast<int>(m), meshes[m]);
  empty_->setVisible(meshes.empty());
  empty_->setText(workbench_.has_volume() ? tr("There is no segmentation yet.") : tr("Open a volume first."));
  const bool any_reference = std::any_of(meshes.begin(), meshes.end(),
                                         [this](const MeshItem& item) { return workbench_.references().has(item); });
  set_enabled(save_, !checker_->checks().empty(), tr("There is nothing to save yet"));
  if (colours_->currentIndex() == 1 && !any_reference) colours_->setCurrentIndex(0);
  set_enabled(colours_, !meshes.empty(), tr("There is no segmentation yet"));
}

void CheckPanel::choose_reference(ItemId mesh) {
  QMenu menu(this);
  const MeshItem* item = workbench_.scene().find_mesh(mesh);
  if (!item) return;
  const auto add = [&](const QString& title, std::optional<Reference> reference) {
    QAction* action = menu.addAction(title, this, [=, this] { workbench_.apply(SetReference{mesh, reference}); });
    action->setCheckable(true);
    action->setChecked(
        reference.has_value() == item->reference.has_value() &&
        (!reference || (reference->labels == item->reference->labels && reference->value == item->reference->value)));
  };
  add(tr("No reference"), std::nullopt);
  for (const auto& [path, labels] : workbench_.references().all()) {
    menu.addSection(QFileInfo(QString::fromStdString(path)).fileName());
    add(tr("All voxels that are not 0"), Reference{path, std::nullopt});
    for (const LabelCount& label : count_labels(labels, {}, 40))
      add(tr("Label %1, %2").arg(label.value, 0, 'g', 10).arg(text(volume_text(1000 * label.millilitres))),
          Reference{path, label.value});
  }
  if (workbench_.references().all().empty()) menu.addAction(tr("Load reference labels first"))->setEnabled(false);
  menu.exec(QCursor::pos());
}

std::string CheckPanel::csv() const {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "mesh,volume_ml,area_cm2,mean,deviation,reference,label,dice,hd95_mm,assd_mm,"
          "long_axis_mm,short_axis_mm,slice\n";
  for (const MeshCheck& check : checker_->checks()) {
    text << csv_field(check.name) << ',' << check.volume_ml << ',' << check.area_cm2 << ',';
    if (check.inside) text << check.inside->mean << ',' << check.inside->deviation;
    text << (check.inside ? "," : ",,");
    const MeshItem* item = workbench_.scene().find_mesh(check.mesh);
    if (item && check.agreement && item->reference) {
      text << csv_field(item->reference->labels) << ',';
      if (item->reference->value) text << *item->reference->value;
      text << ',' << check.agreement->dice << ',' << check.agreement->hd95_mm << ',' << check.agreement->assd_mm;
    } else {
      text << ",,,,";
    }
    text << ',';
    if (check.axes) text << check.axes->long_mm() << ',' << check.axes->short_mm() << ',' << check.axes->slice;
    text << (check.axes ? "" : ",,");
    text << '\n';
  }
  return text.str();
}

void CheckPanel::save_to(const QString& path) const {
  AtomicFile file(to_path(path));
  write_bytes(file, csv());
  file.commit();
}

void CheckPanel::choose_and_save() {
  ask_and_save(this, workbench_, {tr("Save the measurements"), "measurements.csv", tr("Table (*.csv)")},
               [this](const QString& path) { save_to(path); });
}

}  // namespace simplexseg
