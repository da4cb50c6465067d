// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>

namespace simplexseg {

class TrainDialog;
class Workbench;

/// Menu of the model of the active segmentation's organ (docs/models.md): choose a file, remove the
/// model, or train one.
class ModelMenu : public QMenu {
  Q_OBJECT
 public:
  ModelMenu(Workbench& workbench, QWidget* parent);
  /// Sets the model of the active segmentation from a file; shows the reason if that fails.
  void choose(const QString& path);

 private:
  void ask_file();
  void open_training();
  void refresh();

  Workbench& workbench_;
  QAction *choose_, *remove_, *train_;
  TrainDialog* dialog_ = nullptr;
};

}  // namespace simplexseg
