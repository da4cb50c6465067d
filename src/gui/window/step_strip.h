// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>

class QToolButton;

namespace simplexseg {

class ActionTable;
class ElidedLabel;
class Workbench;

/// Strip with the three steps Open, Seed and Correct: marks the next step and shows how to do it. Its height is
/// constant, so that no view moves.
class StepStrip : public QFrame {
 public:
  StepStrip(Workbench& workbench, ActionTable& actions, QWidget* parent);
  QString hint() const;
  /// Next step: 0 Open, 1 Seed, 2 Correct.
  int step() const;

 private:
  void refresh();

  Workbench& workbench_;
  QToolButton* steps_[3];
  ElidedLabel* hint_;
};

}  // namespace simplexseg
