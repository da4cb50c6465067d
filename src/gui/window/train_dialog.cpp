// SPDX-License-Identifier: Apache-2.0
#include "gui/window/train_dialog.h"

#include <QCheckBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QLineEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <thread>

#include "core/error.h"
#include "core/number_text.h"
#include "core/thread_pool.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/platform/load_progress.h"
#include "io/scene/mesh_model.h"
#include "io/volume/volume_io.h"
#include "session/paint.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace {

enum CaseColumn { kImage, kLabels, kLabel, kMirror, kCaseColumns };
constexpr int kJobsBetweenChecks = 8;  ///< jobs of a training between checks for a cancellation

/// Runs the work of a training; throws Cancelled after a cancellation.
TrainedTable train_in_background(const TableTraining& training, const std::filesystem::path& path) {
  ThreadPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())), true);
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) {
    for (int first = 0; first < jobs; first += kJobsBetweenChecks) {
      check_cancelled();
      pool.run(std::min(kJobsBetweenChecks, jobs - first), [&](int j) { job(first + j); });
    }
  };
  TrainedTable trained = train_from_table(training, run, [](double share) { report_progress(share, 1); });
  write_model(path, trained.file);
  return trained;
}

}  // namespace

TrainDialog::TrainDialog(Workbench& workbench, QWidget* parent)
    : QDialog(parent),
      workbench_(workbench),
      list_(new QTableWidget(0, kCaseColumns, this)),
      name_(new QLineEdit(this)),
      modality_(new QLineEdit(this)),
      base_(new QLabel(this)),
      message_(new QLabel(this)),
      use_(new QCheckBox(tr("&Use the model for the active segmentation"), this)),
      progress_(new QProgressBar(this)),
      job_(new BackgroundJob(this)) {
  setObjectName("train_dialog");
  setWindowTitle(tr("Train a model from accepted cases"));
  resize(760, 520);
  fit_on_screen(*this);
  auto* column = new QVBoxLayout(this);
  auto* intro =
      new QLabel(tr("A model learns shape and appearance of an organ, or of several and their relations, from images "
                    "with correct labels. Four cases are useful for bones, ten or more for soft organs."),
                 this);
  intro->setWordWrap(true);
  column->addWidget(intro);
  list_->setObjectName("training_cases");
  list_->setAccessibleName(tr("Training cases"));
  list_->setHorizontalHeaderLabels({tr("Image"), tr("Labels"), tr("Label"), tr("Mirror")});
  list_->horizontalHeaderItem(kLabel)->setToolTip(
      tr("Value or name of the label; empty: all voxels that are not 0.\n"
         "Several organs in one model: their labels, separated by ;"));
  list_->horizontalHeaderItem(kMirror)->setToolTip(
      tr("Mirrors the case left to right, for the organ of the other side"));
  list_->horizontalHeader()->setSectionResizeMode(kImage, QHeaderView::Stretch);
  list_->horizontalHeader()->setSectionResizeMode(kLabels, QHeaderView::Stretch);
  list_->setSelectionBehavior(QAbstractItemView::SelectRows);
  column->addWidget(list_, 1);
  auto* edit = new QHBoxLayout;
  const auto button = [&](QHBoxLayout* row, const QString& title, const char* object, auto slot) {
    auto* made = new QPushButton(title, this);
    made->setObjectName(object);
    made->setAutoDefault(false);
    connect(made, &QPushButton::clicked, this, slot);
    row->addWidget(made);
    return made;
  };
  button(edit, tr("&Open a table..."), "open_case_table", &TrainDialog::ask_table);
  button(edit, tr("&Add a case..."), "add_case", &TrainDialog::ask_case);
  active_ = button(edit, tr("Add the a&ctive segmentation..."), "add_active_case", &TrainDialog::ask_active);
  remove_ = button(edit, tr("&Remove"), "remove_cases", [this] {
    QList<int> rows;
    for (const QModelIndex& index : list_->selectionModel()->selectedRows()) rows.append(index.row());
    std::sort(rows.rbegin(), rows.rend());
    for (const int row : rows) list_->removeRow(row);
    refresh();
  });
  edit->addStretch();
  column->addLayout(edit);
  auto* form = new QFormLayout;
  name_->setPlaceholderText(tr("for example: Left kidney"));
  modality_->setPlaceholderText(tr("for example: CT"));
  form->addRow(tr("&Name of the organ"), name_);
  form->addRow(tr("&Modality"), modality_);
  auto* base_row = new QHBoxLayout;
  base_row->addWidget(base_, 1);
  button(base_row, tr("Add to a mo&del..."), "choose_base", &TrainDialog::ask_base);
  button(base_row, tr("New model"), "new_model", [this] { set_base({}); });
  form->addRow(tr("Begin with"), base_row);
  column->addLayout(form);
  use_->setObjectName("use_trained_model");
  use_->setChecked(true);
  column->addWidget(use_);
  message_->setObjectName("training_message");
  message_->setWordWrap(true);
  message_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  column->addWidget(message_);
  progress_->setRange(0, 100);
  column->addWidget(progress_);
  auto* end = new QHBoxLayout;
  end->addStretch();
  train_ = button(end, tr("&Train..."), "train", &TrainDialog::ask_model);
  cancel_ = button(end, tr("Cancel training"), "cancel_training", [this] { job_->cancel(); });
  button(end, tr("Close"), "close_training", &QDialog::close);
  column->addLayout(end);
  connect(list_->selectionModel(), &QItemSelectionModel::selectionChanged, this, &TrainDialog::refresh);
  connect(&workbench_, &Workbench::scene_changed, this, &TrainDialog::refresh);
  connect(job_, &BackgroundJob::progressed, this,
          [this](double share) { progress_->setValue(static_cast<int>(100 * share)); });
  connect(job_, &BackgroundJob::failed, this, [this](const QString& why) {
    show_message(why, true);
    refresh();
  });
  connect(job_, &BackgroundJob::cancelled, this, [this] {
    show_message(tr("Cancelled. No file was written."));
    refresh();
  });
  set_base({});
}

bool TrainDialog::busy() const { return job_->busy(); }

void TrainDialog::show_message(const QString& message, bool is_warning) {
  message_->setText(message);
  set_role(message_, is_warning ? "warning" : "");
}

void TrainDialog::add_case(const QString& image, const QString& labels, const QString& label, bool mirror) {
  const int row = list_->rowCount();
  list_->insertRow(row);
  const QString texts[]{image, labels, label};
  for (const int c : {kImage, kLabels, kLabel}) {
    auto* item = new QTableWidgetItem(texts[c]);
    if (c != kLabel) {
      item->setFlags(item->flags() & ~Qt::ItemIsEditable);
      item->setText(QFileInfo(texts[c]).fileName());
      item->setData(Qt::UserRole, texts[c]);
      item->setToolTip(texts[c]);
    }
    list_->setItem(row, c, item);
  }
  auto* mirrored = new QTableWidgetItem;
  mirrored->setFlags(Qt::ItemIsEnabled | Qt::ItemIsSelectable | Qt::ItemIsUserCheckable);
  mirrored->setCheckState(mirror ? Qt::Checked : Qt::Unchecked);
  list_->setItem(row, kMirror, mirrored);
  refresh();
}

std::vector<TableCase> TrainDialog::cases() const {
  std::vector<TableCase> all;
  for (int row = 0; row < list_->rowCount(); ++row) {
    TableCase& one = all.emplace_back();
    one.image = to_path(list_->item(row, kImage)->data(Qt::UserRole).toString());
    one.organs = organ_labels(to_path(list_->item(row, kLabels)->data(Qt::UserRole).toString()).string(),
                              list_->item(row, kLabel)->text().toStdString(),
                              [](const std::string& file) { return std::filesystem::path(file); });
    one.mirror = list_->item(row, kMirror)->checkState() == Qt::Checked;
    one.name = shown_path(list_->item(row, kImage)->text());
  }
  return all;
}

void TrainDialog::open_table(const QString& path) {
  try {
    for (const TableCase& one : read_case_table(to_path(path)))
      add_case(text(one.image), text(files_text(one.organs)), text(labels_text(one.organs)), one.mirror);
    show_message({});
  } catch (const Error& error) {
    show_message(QString::fromUtf8(error.what()), true);
  }
}

void TrainDialog::add_active(const QString& labels) {
  try {
    const Scene& scene = workbench_.session().scene();
    const MeshItem* const item = scene.find_mesh(workbench_.view.active_mesh);
    if (!item) return;
    const VolumeGeometry& grid = workbench_.session().volume().geometry();
    const Mask mask = object_mask(item->mesh, paint_of(scene, item->id), grid);
    Volume volume(grid, VoxelType::UInt8);
    std::ranges::copy(mask.voxels, volume.voxels<std::uint8_t>().begin());
    write_volume(to_path(labels), volume);
    add_case(text(std::filesystem::path(scene.volume_path)), labels);
    show_message({});
  } catch (const Error& error) {
    show_message(QString::fromUtf8(error.what()), true);
  }
}

void TrainDialog::set_base(const QString& model) {
  base_path_ = model;
  base_->setText(model.isEmpty() ? tr("a new model") : QFileInfo(model).fileName());
  base_->setToolTip(model);
  for (QLineEdit* field : {name_, modality_}) field->setEnabled(model.isEmpty());
  refresh();
}

void TrainDialog::train(const QString& model) {
  TableTraining training;
  try {
    training.rows = cases();
  } catch (const Error& error) {
    show_message(QString::fromUtf8(error.what()), true);
    return;
  }
  training.name = name_->isEnabled() ? name_->text().trimmed().toStdString() : "";
  training.modality = modality_->isEnabled() ? modality_->text().trimmed().toStdString() : "";
  training.add_to = to_path(base_path_);
  auto trained = std::make_shared<TrainedTable>();
  const bool started = job_->start(
      tr("Training"), [training, path = to_path(model), trained] { *trained = train_in_background(training, path); },
      [this, model, trained] { finish(model, *trained); }, BackgroundJob::Cancellable::Yes);
  if (started) show_message(tr("Training from %1...").arg(counted_text(list_->rowCount(), "case")));
  progress_->setValue(0);
  refresh();
}

void TrainDialog::finish(const QString& model, const TrainedTable& trained) {
  const OrganModel& organ = trained.file.organs.front();
  QString message =
      tr("%1: %2, error on unseen cases %3.")
          .arg(QFileInfo(model).fileName(), counted_text(static_cast<std::int64_t>(organ.cases.size()), "case"),
               text(length_text(organ.surface_error_mm)));
  for (const std::string& warning : trained.warnings) message += '\n' + text(warning);
  progress_->setValue(100);
  if (use_->isChecked() && use_->isEnabled()) {
    try {
      workbench_.apply(SetModel{workbench_.view.active_mesh, load_mesh_model(to_path(model).string(), {})});
    } catch (const Error& error) {
      message += '\n' + QString::fromUtf8(error.what());
    }
  }
  show_message(message);
  refresh();
  emit finished_training(model);
}

void TrainDialog::ask_table() {
  const QString path = local_path(QFileDialog::getOpenFileUrl(this, tr("Choose a table of cases"), {},
                                                              tr("Tables (*.csv *.tsv *.txt);;All files (*)")));
  if (!path.isEmpty()) open_table(path);
}
void TrainDialog::ask_case() {
  const QString image = local_path(QFileDialog::getOpenFileUrl(this, tr("Choose the image of the case")));
  if (image.isEmpty()) return;
  const QString labels = local_path(
      QFileDialog::getOpenFileUrl(this, tr("Choose the labels of the case"), url_of(QFileInfo(image).path())));
  if (!labels.isEmpty()) add_case(image, labels);
}
void TrainDialog::ask_active() {
  const QString path = local_path(QFileDialog::getSaveFileUrl(this, tr("Save the labels of this case"), {},
                                                              tr("Labels (*.nii.gz *.nrrd *.mha);;All files (*)")));
  if (!path.isEmpty()) add_active(path);
}
void TrainDialog::ask_base() {
  const QString path = local_path(QFileDialog::getOpenFileUrl(this, tr("Choose the model to which the cases are added"),
                                                              {}, tr("Models (*.model);;All files (*)")));
  if (!path.isEmpty()) set_base(path);
}
void TrainDialog::ask_model() {
  QString path =
      local_path(QFileDialog::getSaveFileUrl(this, tr("Save the model"), {}, tr("Models (*.model);;All files (*)")));
  if (path.isEmpty()) return;
  if (QFileInfo(path).suffix().isEmpty()) path += kModelExtension;
  train(path);
}

void TrainDialog::refresh() {
  const bool training = job_->busy();
  const MeshItem* const active = workbench_.active_mesh();
  const bool has_file = !workbench_.scene().volume_path.empty() && workbench_.scene().volume_number <= 1;
  set_enabled(train_, list_->rowCount() > 0 && !training,
              training ? tr("A training is running") : tr("Add a case first"));
  set_enabled(cancel_, training, tr("No training is running"));
  set_enabled(remove_, !list_->selectionModel()->selectedRows().isEmpty(), tr("Select cases in the table first"));
  set_enabled(active_, active && active->locked && has_file,
              active && active->locked ? tr("The image is not a file with one volume")
                                       : tr("Accept the active segmentation first: lock it"));
  set_enabled(use_, active && !active->locked && !active->start,
              tr("The active segmentation is locked, or does not start from a seed"));
  progress_->setVisible(training);
}

}  // namespace simplexseg
