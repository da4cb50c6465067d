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

enum Measure {
  kVolumeBefore,
  kVolumeNow,
  kVolumeChange,
  kLongAxes,
  kShortAxes,
  kCentroidShift,
  kCarriedDice,
  kMeasures
};
constexpr int kShortestPauseMs = 500;
constexpr int kPausePerWork = 3;  ///< pause over time of a measurement: at most a quarter of one core is used

bool is_carried(const MeshItem& item) { return item.start && item.start->earlier.volume_ml > 0; }

}  // namespace

bool has_follow_up(const Scene& scene) { return std::ranges::any_of(scene.meshes, is_carried); }

FollowPanel::FollowPanel(Workbench& workbench, QWidget* parent)
    : QWidget(parent),
      workbench_(workbench),
      job_(new BackgroundJob(this)),
      table_(new QTableWidget(kMeasures, 0, this)),
      note_(new QLabel(this)),
      save_(new QPushButton(tr("Save table..."), this)) {
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(8, 6, 8, 6);
  const std::pair<QString, QString> rows[kMeasures] = {
      {tr("Before"), tr("Volume in the earlier study")},
      {tr("Now"), tr("Volume in this study")},
      {tr("Change"), tr("Difference of the volumes per earlier volume")},
      {tr("Long axis"), tr("Longest diameter in an axial slice (RECIST 1.1) in the earlier study and in this one, mm")},
      {tr("Short axis"), tr("Longest diameter perpendicular to the long axis (RECIST 1.1) in both studies, mm")},
      {tr("Shift"), tr("Distance of the centroids of the carried and the present surface: motion that the "
                       "registration does not explain")},
      {tr("Dice"), tr("Overlap of the carried and the present surface: 1 = identical, 0 = no overlap")}};
  for (int row = 0; row < kMeasures; ++row) {
    auto* head = new QTableWidgetItem(rows[row].first);
    head->setToolTip(rows[row].second);
    table_->setVerticalHeaderItem(row, head);
  }
  table_->setObjectName("follow_table");
  table_->setAccessibleName(tr("Comparison with the earlier study"));
  make_read_only(*table_);
  table_->setSelectionMode(QAbstractItemView::NoSelection);
  table_->verticalHeader()->setSectionResizeMode(QHeaderView::Fixed);
  table_->verticalHeader()->setDefaultSectionSize(table_->fontMetrics().height() + 8);
  table_->horizontalHeader()->setDefaultAlignment(Qt::AlignLeft | Qt::AlignVCenter);
  table_->horizontalHeader()->setTextElideMode(Qt::ElideRight);
  table_->setMinimumHeight(80);
  column->addWidget(table_, 1);
  note_->setWordWrap(true);
  set_role(note_, "dim");
  column->addWidget(note_);
  column->addWidget(save_);
  pause_.setSingleShot(true);
  connect(&pause_, &QTimer::timeout, this, &FollowPanel::measure_if_due);
  connect(save_, &QPushButton::clicked, this, &FollowPanel::choose_and_save);
  connect(table_, &QTableWidget::cellClicked, this, [this](int, int object) {
    const std::string name = rows_[static_cast<std::size_t>(object)].name;
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
  table_->setColumnCount(static_cast<int>(rows_.size()));
  constexpr std::size_t kFitting = 2;  // number of columns that fit without scrolling
  table_->horizontalHeader()->setSectionResizeMode(rows_.size() <= kFitting ? QHeaderView::Stretch
                                                                            : QHeaderView::ResizeToContents);
  for (std::size_t column = 0; column < rows_.size(); ++column) {
    const FollowUpRow& object = rows_[column];
    const QString name = object.locked ? tr("%1 (locked)").arg(text(object.name)) : text(object.name);
    auto* head = new QTableWidgetItem(swatch(object.colour), name);
    head->setToolTip(name);
    table_->setHorizontalHeaderItem(static_cast<int>(column), head);
    const auto both = [](double before_mm, double now_mm) {
      const auto shown = [](double mm) { return mm > 0 ? QString::number(mm, 'f', 1) : tr("none"); };
      return QString("%1 \u2192 %2").arg(shown(before_mm), shown(now_mm));
    };
    QString texts[kMeasures];
    texts[kVolumeBefore] = text(volume_text(1000 * object.earlier.volume_ml));
    texts[kVolumeNow] = text(volume_text(1000 * object.now.volume_ml));
    texts[kVolumeChange] = QString(object.change_ml() < 0 ? "%1%" : "+%1%").arg(object.change_percent(), 0, 'f', 1);
    texts[kLongAxes] = both(object.earlier.long_mm, object.now.long_mm);
    texts[kShortAxes] = both(object.earlier.short_mm, object.now.short_mm);
    texts[kCentroidShift] = tr("%1 mm").arg(object.shift_mm, 0, 'f', 1);
    texts[kCarriedDice] = QString::number(object.dice, 'f', 3);
    for (int row = 0; row < kMeasures; ++row) {
      auto* cell = new QTableWidgetItem(texts[row]);
      cell->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
      if (row == kCentroidShift)
        cell->setToolTip(tr("%1 mm by the positions in the files").arg(object.unregistered_shift_mm, 0, 'f', 1));
      table_->setItem(row, static_cast<int>(column), cell);
    }
  }
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
