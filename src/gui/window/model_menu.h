// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>
#include <optional>

namespace simplexseg {

class BackgroundJob;
struct ModelFile;
class TrainDialog;
class Workbench;

/// Menu of the model of the active segmentation's organ (docs/models.md): choose a file, remove the
/// model, or train one.
class ModelMenu : public QMenu {
  Q_OBJECT
 public:
  ModelMenu(Workbench& workbench, QWidget* parent);
  /// Sets the model of the active segmentation from a file; asks for the organ if it has several. Shows the reason if
  /// that fails.
  void choose(const QString& path);
  /// Finds the organs of the active segmentation's model that have no segmentation yet, in the background, and adds a
  /// segmentation for each.
  void start_organs();

 signals:
  void organs_started();

 private:
  struct Search;
  /// Index of the organ of a model that the user chooses; nothing if cancelled.
  std::optional<int> ask_organ(const ModelFile& model);
  void add_organs(const Search& search);
  void ask_file();
  void open_training();
  void refresh();

  Workbench& workbench_;
  QAction *choose_, *start_, *remove_, *train_;
  BackgroundJob* job_;
  TrainDialog* dialog_ = nullptr;
};

}  // namespace simplexseg
