// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

class QListWidget;

namespace simplexseg {

class Workbench;

/// Undo history, oldest action first, with an arrow at the current state; undone actions are listed below it. A click
/// on an action undoes or redoes until the state directly after that action.
class HistoryPanel : public QWidget {
  Q_OBJECT
 public:
  HistoryPanel(Workbench& workbench, QWidget* parent);

 protected:
  void showEvent(QShowEvent* event) override;

 private:
  void refresh();

  Workbench& workbench_;
  QListWidget* list_;
  bool going_ = false;  ///< a click is being handled: the list must not be rebuilt
};

}  // namespace simplexseg
