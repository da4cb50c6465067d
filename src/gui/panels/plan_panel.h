// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <cstdint>

#include "session/step_plan.h"

class QLabel;
class QTreeWidget;
class QTreeWidgetItem;

namespace simplexseg {

class Workbench;

/// What a step holds and computes, and what it leaves out and why (StepPlan), as it is now.
class PlanPanel : public QWidget {
  Q_OBJECT
 public:
  PlanPanel(Workbench& workbench, QWidget* parent);
  /// What is shown. Empty until the panel has been looked at.
  const StepPlan& shown() const { return shown_; }
  /// Whether the user can see the panel; out of sight it asks for no plan. (A widget behind another's tab is
  /// "visible".)
  void set_in_sight(bool in_sight);
  bool in_sight() const { return in_sight_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void refresh();
  void refresh_totals();
  void fill();
  void add_needed(const QString& title, const QString& tip, const char* what);
  void add_left_out();
  QTreeWidgetItem* add_group(const QString& title, const QString& value, const QString& tip);
  void fit_reasons();

  Workbench& workbench_;
  QLabel* totals_;
  QTreeWidget* list_;
  bool in_sight_ = false;
  StepPlan shown_;
  std::uint64_t shown_topology_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
