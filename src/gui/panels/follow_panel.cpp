// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/follow_panel.h"

#include <QAbstractButton>
#include <QElapsedTimer>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <memory>
#include <utility>

#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/ask_and_save.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "image/measurement.h"
#include "io/platform/atomic_file.h"

namespace simplexseg {
namespace {

enum Column { kObject, kBefore, kNow, kChange, kAxis, kShift, kOverlap, kColumns };
constexpr int kShortestPauseMs = 500;
constexpr int kPausePerWork = 3;  ///< pause over time of a measurement: at most a quarter of one core is used

QString millilitres(double ml) { return text(volume_text(1000 * ml)); }

bool is_carried(const MeshItem& item) { return item.start && item.start->earlier.volume_ml > 0; }

}  // namespace

bool has_follow_up(const Scene& scene) { return std::ranges::any_of(scene.meshes, is_carried); }

FollowPanel::FollowPanel(Workbench& workbench, QWidget* parent)
    : QWidget(parent),
      workbench_(workbench),
      job_(new BackgroundJob(this)),
      table_(new QTableWidget(0, kColumns, this)),
      note_(new QLabel(this)),
      save_(new QPushButton(tr("Save table..."), this)) {
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(8, 6, 8, 6);
  const std::pair<QString, QString> titles[kColumns] = {
      {tr("Object"), tr("Segmentation that was carried over; a click makes it active")},
      {tr("Before"), tr("Volume in the earlier study")},
      {tr("Now"), tr("Volume in this study")},
      {tr("Change"), tr("Difference of the volumes per earlier volume")},
      {tr("Long axis"), tr("Longest diameter in an axial slice (RECIST 1.1) in the earlier study and in this one, mm")},
      {tr("Shift"), tr("Distance of the centroids of the carried and the present surface: motion that the "
                       "registration does not explain")},
      {tr("Dice"), tr("Overlap of the carried and the present surface: 1 = identical, 0 = no overlap")}};
  for (int n = 0; n < kColumns; ++n) {
    auto* head = new QTableWidgetItem(titles[n].first);
    head->setToolTip(titles[n].second);
    table_->setHorizontalHeaderItem(n, head);
  }
  table_->setObjectName("follow_table");
  table_->setAccessibleName(tr("Comparison with the earlier study"));
  for (auto* corner : table_->findChildren<QAbstractButton*>()) corner->setAccessibleName(tr("Corner of the table"));
  table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table_->setSelectionMode(QAbstractItemView::NoSelection);
  table_->setWordWrap(false);
  table_->verticalHeader()->hide();
  table_->horizontalHeader()->setHighlightSections(false);
  table_->setMinimumHeight(80);
  column->addWidget(table_, 1);
  note_->setWordWrap(true);
  set_role(note_, "dim");
  column->addWidget(note_);
  column->addWidget(save_);
  pause_.setSingleShot(true);
  connect(&pause_, &QTimer::timeout, this, &FollowPanel::measure_if_due);
  connect(save_, &QPushButton::clicked, this, &FollowPanel::choose_and_save);
  connect(table_, &QTableWidget::cellClicked, this, [this](int row) {
    const std::string name = rows_[static_cast<std::size_t>(row)].name;
    if (const MeshItem* const item = workbench_.scene().find_mesh(name)) workbench_.set_active_mesh(item->id);
  });
  connect(&workbench_, &Workbench::pose_changed, this, &FollowPanel::measure_if_due);
  connect(&workbench_, &Workbench::scene_changed, this, &FollowPanel::measure_if_due);
  connect(&workbench_, &Workbench::volume_changed, this, [this] {
    rows_.clear();
    ++study_;
    measured_revision_ = ~std::uint64_t{0};
    refresh();
  });
  connect(job_, &BackgroundJob::failed, this, [this](const QString& why) {
    measured_revision_ = workbench_.session().revision();
    workbench_.notify(Severity::Warning, tr("The segmentations cannot be compared: %1").arg(why));
  });
  refresh();
}

void FollowPanel::set_on_screen(bool on_screen) {
  on_screen_ = on_screen;
  measure_if_due();
}

void FollowPanel::measure_if_due() {
  if (!on_screen_ || job_->busy() || pause_.isActive() || !has_follow_up(workbench_.scene()) ||
      measured_revision_ == workbench_.session().revision())
    return;
  auto copy = std::make_shared<Scene>();
  try {
    for (const MeshItem& item : workbench_.session().scene().meshes) {
      if (!is_carried(item)) continue;
      MeshItem& mesh = copy->meshes.emplace_back();
      mesh.name = item.name, mesh.colour = item.colour, mesh.locked = item.locked;
      mesh.start = item.start, mesh.mesh = item.mesh;
    }
  } catch (const std::exception&) {
    return;  // the device was lost while poses were read; the next step reports the loss
  }
  struct Result {
    std::vector<FollowUpRow> rows;
    std::int64_t ms = 0;
  };
  const auto result = std::make_shared<Result>();
  job_->start(
      tr("Comparing with the earlier study..."),
      [=, geometry = workbench_.session().volume().geometry()] {
        QElapsedTimer clock;
        clock.start();
        result->rows = follow_up_rows(*copy, geometry);
        result->ms = clock.elapsed();
      },
      [=, this, study = study_, revision = workbench_.session().revision()] {
        if (study != study_) return measure_if_due();
        rows_ = std::move(result->rows);
        measured_revision_ = revision;
        pause_.start(std::max<int>(kShortestPauseMs, static_cast<int>(kPausePerWork * result->ms)));
        refresh();
      });
}

void FollowPanel::refresh() {
  table_->setRowCount(static_cast<int>(rows_.size()));
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const FollowUpRow& object = rows_[row];
    QString texts[kColumns];
    texts[kObject] = object.locked ? tr("%1 (locked)").arg(text(object.name)) : text(object.name);
    texts[kBefore] = millilitres(object.earlier.volume_ml);
    texts[kNow] = millilitres(object.now.volume_ml);
    texts[kChange] =
        QString("%1%2%").arg(object.change_ml() < 0 ? QString() : QString("+")).arg(object.change_percent(), 0, 'f', 1);
    const auto axis = [](double mm) { return mm > 0 ? QString::number(mm, 'f', 1) : tr("none"); };
    texts[kAxis] = QString("%1 \u2192 %2").arg(axis(object.earlier.long_mm), axis(object.now.long_mm));
    texts[kShift] = tr("%1 mm").arg(object.shift_mm, 0, 'f', 1);
    texts[kOverlap] = QString::number(object.dice, 'f', 3);
    for (int n = 0; n < kColumns; ++n) {
      auto* cell = new QTableWidgetItem(texts[n]);
      if (n == kObject) {
        cell->setIcon(swatch(object.colour));
        cell->setToolTip(texts[n]);
      } else {
        cell->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
      }
      if (n == kAxis)
        cell->setToolTip(
            tr("Short axis: %1 \u2192 %2 mm").arg(axis(object.earlier.short_mm), axis(object.now.short_mm)));
      if (n == kShift)
        cell->setToolTip(tr("%1 mm by the positions in the files").arg(object.unregistered_shift_mm, 0, 'f', 1));
      table_->setItem(static_cast<int>(row), n, cell);
    }
  }
  table_->resizeColumnsToContents();
  note_->setText(rows_.empty() ? tr("Nothing has been compared yet.")
                 : workbench_.scene().layers.empty()
                     ? tr("Measures in the earlier study and of the present surfaces.")
                     : tr("Measures in the earlier study and of the present surfaces. M shows layers, U a swipe."));
  set_enabled(save_, !rows_.empty(), tr("There is nothing to save yet"));
}

void FollowPanel::choose_and_save() {
  ask_and_save(this, workbench_, {tr("Save the comparison"), "follow-up.csv", tr("Table (*.csv)")},
               [this](const QString& path) {
                 AtomicFile file(to_path(path));
                 write_bytes(file, follow_up_csv(rows_));
                 file.commit();
               });
}

}  // namespace simplexseg
