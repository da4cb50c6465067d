// SPDX-License-Identifier: Apache-2.0
#include "gui/window/model_menu.h"

#include <QFileDialog>
#include <QFileInfo>

#include "core/error.h"
#include "gui/input/key_map.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/window/train_dialog.h"
#include "gui/workbench/workbench.h"
#include "io/scene/mesh_model.h"
#include "model/organ_model.h"

namespace simplexseg {

ModelMenu::ModelMenu(Workbench& workbench, QWidget* parent)
    : QMenu(tr("&Model of the organ"), parent),
      workbench_(workbench),
      choose_(addAction(tr("&Choose a model..."))),
      remove_(addAction(tr("&Remove the model"))),
      train_(addAction(tr("&Train from accepted cases..."))) {
  setObjectName("model_menu");
  setToolTipsVisible(true);
  choose_->setObjectName("choose_model");
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
    workbench_.apply(SetModel{workbench_.view.active_mesh, load_mesh_model(file, {})});
  } catch (const Error& error) {
    workbench_.notify(Severity::Failure, QString::fromStdString(error.what()));
  }
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
  set_enabled(remove_, has_model && !locked, has_model ? why_locked() : tr("This segmentation has no model"));
}

}  // namespace simplexseg
