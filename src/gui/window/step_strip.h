// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>

class QToolButton;

namespace simplexseg {

class ActionTable;
class ElidedLabel;
class Workbench;

/// Open, Seed, Correct: which of the three steps is next, and the gesture that does it. It is always as high as now, so
/// that no view moves.
class StepStrip : public QFrame {
 public:
  StepStrip(Workbench& workbench, ActionTable& actions, QWidget* parent);
  QString hint() const;
  /// 0 Open, 1 Seed, 2 Correct.
  int step() const;

 private:
  void refresh();

  Workbench& workbench_;
  QToolButton* steps_[3];
  ElidedLabel* hint_;
};

}  // namespace simplexseg
