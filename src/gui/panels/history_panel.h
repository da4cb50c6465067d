// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>

class QListWidget;

namespace simplexseg {

class Workbench;

/// What was done, the oldest first, with a mark at the present; what was taken back stands below it. A click on an
/// entry goes to just after it, by as many steps of undo or redo as that takes.
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
  bool going_ = false;  ///< the list must not be rebuilt under the click
};

}  // namespace simplexseg
