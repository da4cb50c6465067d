// SPDX-License-Identifier: Apache-2.0
#include "gui/window/model_menu.h"

#include <QFileDialog>
#include <QFileInfo>
#include <QInputDialog>
#include <algorithm>
#include <thread>

#include "core/error.h"
#include "core/thread_pool.h"
#include "gui/input/key_map.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/window/train_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/scene/mesh_model.h"
#include "model/model_start.h"
#include "model/organ_model.h"
#include "model/template_registration.h"

namespace simplexseg {

ModelMenu::ModelMenu(Workbench& workbench, QWidget* parent)
    : QMenu(tr("&Model of the organ"), parent),
      workbench_(workbench),
      choose_(addAction(tr("&Choose a model..."))),
      start_(addAction(tr("&Find the other organs of the model"))),
      remove_(addAction(tr("&Remove the model"))),
      train_(addAction(tr("&Train from accepted cases..."))),
      job_(new BackgroundJob(this)) {
  setObjectName("model_menu");
  setToolTipsVisible(true);
  choose_->setObjectName("choose_model");
  start_->setObjectName("start_organs");
  connect(start_, &QAction::triggered, this, &ModelMenu::start_organs);
  connect(job_, &BackgroundJob::failed, this, [this](const QString& why) {
    workbench_.notify(Severity::Failure, why);
    refresh();
  });
  remove_->setObjectName("remove_model");
  train_->setObjectName("train_model");
  insertSeparator(train_);
  train_->setToolTip(tr("Learns shape and appearance of an organ from images with correct labels"));
  connect(train_, &QAction::triggered, this, &ModelMenu::open_training);
  connect(choose_, &QAction::triggered, this, &ModelMenu::ask_file);
  connect(remove_, &QAction::triggered, this, [this] {
    workbench_.apply(SetModel{workbench_.view.active_mesh, nullptr});
  });
  connect(&workbench_, &Workbench::scene_changed, this, &ModelMenu::refresh);
  refresh();
}

void ModelMenu::ask_file() {
  const QString path = local_path(QFileDialog::getOpenFileUrl(
      parentWidget()->window(), tr("Choose the model of an organ"), {}, tr("Models (*.model);;All files (*)")));
  if (!path.isEmpty()) choose(path);
}

void ModelMenu::open_training() {
  if (!dialog_) dialog_ = new TrainDialog(workbench_, parentWidget()->window());
  dialog_->show();
  dialog_->raise();
  dialog_->activateWindow();
}

void ModelMenu::choose(const QString& path) {
  try {
    const std::string file = QFileInfo(path).absoluteFilePath().toStdString();
    const ModelFile model = read_model(file);
    const std::optional<int> organ = ask_organ(model);
    if (organ) workbench_.apply(SetModel{workbench_.view.active_mesh, mesh_model_of(model, file, *organ)});
  } catch (const Error& error) {
    workbench_.notify(Severity::Failure, QString::fromStdString(error.what()));
  }
}

std::optional<int> ModelMenu::ask_organ(const ModelFile& model) {
  if (model.organs.size() == 1) return 0;
  const MeshItem* const active = workbench_.active_mesh();
  QStringList names;
  int likely = 0;
  for (const OrganModel& organ : model.organs) {
    if (active && text(organ.name).compare(text(active->name), Qt::CaseInsensitive) == 0)
      likely = static_cast<int>(names.size());
    names.append(text(organ.name));
  }
  bool accepted = false;
  const QString chosen = QInputDialog::getItem(parentWidget()->window(), tr("Model of several organs"),
                                               tr("Organ of this segmentation:"), names, likely, false, &accepted);
  if (!accepted) return std::nullopt;
  return static_cast<int>(names.indexOf(chosen));
}

/// Search for the other organs of a model.
struct ModelMenu::Search {
  std::string path;
  ModelFile model;
  std::vector<int> wanted;
  std::vector<FoundSeed> seeds;
};

void ModelMenu::start_organs() {
  const Scene& scene = workbench_.session().scene();
  const MeshItem* const active = scene.find_mesh(workbench_.view.active_mesh);
  if (!active || !active->model) return;
  const auto search = std::make_shared<Search>();
  search->path = active->model->path;
  std::vector<std::pair<int, SimplexMesh>> surfaces;
  std::vector<bool> present;
  for (const MeshItem& item : scene.meshes) {
    if (!item.model || item.model->checksum != active->model->checksum) continue;
    const int number = item.model->number;
    if (number >= std::ssize(present)) present.resize(number + 1, false);
    const bool first = !present[number];
    present[number] = true;
    if (first && (item.locked || item.id == active->id)) surfaces.emplace_back(number, item.mesh);
  }
  const auto work = [search, present, surfaces, checksum = active->model->checksum,
                     folder = std::filesystem::path(scene.volume_path).parent_path(),
                     volume = workbench_.session().volume()] {
    search->model = read_model(find_data(search->path, folder));
    if (search->model.checksum != checksum)
      throw Error("model " + quoted(std::filesystem::path(search->path)), "the file has changed since it was chosen",
                  "choose it again");
    const std::vector<OrganModel>& organs = search->model.organs;
    for (int k = 0; k < std::ssize(organs); ++k)
      if (k >= std::ssize(present) || !present[k]) search->wanted.push_back(k);
    std::vector<FoundOrgan> found;
    found.reserve(surfaces.size());
    for (const auto& [number, surface] : surfaces)
      found.push_back({number, register_template(organs[number].shape.mean, surface)});
    ThreadPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())), true);
    search->seeds = find_organs(organs, search->model.relations, volume, found, search->wanted,
                                [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); });
  };
  job_->start(tr("Finding organs"), work, [this, search] { add_organs(*search); });
  refresh();
}

void ModelMenu::add_organs(const Search& search) {
  const ItemId active = workbench_.view.active_mesh;
  QStringList missing;
  for (const int organ : search.wanted) {
    const std::string& name = search.model.organs[organ].name;
    const auto found = std::ranges::find(search.seeds, organ, &FoundSeed::organ);
    if (found == search.seeds.end()) {
      missing.append(text(name));
      continue;
    }
    AddMesh add{};
    add.name = workbench_.scene().find_mesh(name) ? "" : name;
    add.seed = {found->seed.position_mm, found->seed.radius_mm};
    add.model = mesh_model_of(search.model, search.path, organ);
    workbench_.apply(add);
  }
  workbench_.set_active_mesh(active);
  if (search.wanted.empty())
    workbench_.notify(Severity::Note, tr("All organs of the model have a segmentation."));
  else if (!missing.isEmpty())
    workbench_.notify(
        Severity::Warning,
        tr("The model does not recognise %1 in this image. Place a seed in the organ.").arg(missing.join(", ")));
  refresh();
  emit organs_started();
}

void ModelMenu::refresh() {
  const MeshItem* const active = workbench_.active_mesh();
  const bool locked = active && active->locked, started = active && active->start.has_value();
  const QString why = locked ? why_locked()
                      : started
                          ? tr("This segmentation starts from labels or a mesh: start it from a seed to use a model")
                          : tr("There is no segmentation yet: place a seed first (%1)").arg(key_hint(Act::ToolSeed));
  set_enabled(choose_, active && !locked && !started, why);
  const bool has_model = active && active->model;
  const QString name = has_model ? QFileInfo(QString::fromStdString(active->model->path)).fileName() : QString();
  choose_->setText(has_model ? tr("&Choose another model (now: %1)...").arg(QString(name).replace("&", "&&"))
                             : tr("&Choose a model..."));
  if (choose_->isEnabled())
    choose_->setToolTip(
        tr("Shape and appearance of an organ, learned from segmented cases, guide the segmentation. "
           "Train models from segmented cases, below."));
  set_enabled(start_, has_model && !job_->busy(),
              has_model ? tr("The search is running") : tr("This segmentation has no model"));
  if (start_->isEnabled())
    start_->setToolTip(
        tr("Finds the organs of a model of several from this segmentation and those that are locked, and starts a "
           "segmentation of each"));
  set_enabled(remove_, has_model && !locked, has_model ? why_locked() : tr("This segmentation has no model"));
}

}  // namespace simplexseg
