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

/// Lists the arrays and kernels of a simulation step (StepPlan): the size of each array, the bytes that each kernel
/// reads and writes, and the reason why each is needed or not.
class PlanPanel : public QWidget {
  Q_OBJECT
 public:
  PlanPanel(Workbench& workbench, QWidget* parent);
  /// Displayed plan; empty until the panel is visible for the first time.
  const StepPlan& shown() const { return shown_; }
  /// Sets whether the panel is visible to the user; no plan is made while it is hidden.
  void set_on_screen(bool on_screen);
  bool on_screen() const { return on_screen_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void refresh();
  void refresh_totals();
  void fill();
  void add_needed(const QString& title, const QString& tip, const char* what);
  void add_skipped();
  QTreeWidgetItem* add_group(const QString& title, const QString& value, const QString& tip);
  void fit_reasons();

  Workbench& workbench_;
  QLabel* totals_;
  QTreeWidget* list_;
  bool on_screen_ = false;
  StepPlan shown_;
  std::uint64_t shown_topology_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
