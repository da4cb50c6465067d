// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/plan_panel.h"

#include <QHeaderView>
#include <QLabel>
#include <QScrollBar>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <limits>
#include <map>

#include "gui/look/theme.h"
#include "gui/workbench/workbench.h"
#include "io/files.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

constexpr int kName = 0, kWhy = 1, kBytes = 2;

QString text_of(const std::string& text) { return QString::fromStdString(text); }
QString size_of(std::size_t bytes) { return text_of(in_words(static_cast<double>(bytes))); }

std::size_t bytes_of(const StepPlan& plan, const char* what) {
  std::size_t bytes = 0;
  for (const StepPlan::Item& item : plan.items)
    if (item.needed && item.what == what) bytes += item.bytes;
  return bytes;
}

}  // namespace

PlanPanel::PlanPanel(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  totals_ = new QLabel(this);
  totals_->setWordWrap(true);
  totals_->setToolTip(tr("Of the memory that can be had where the scene is computed, what it holds already included"));
  totals_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  layout->addWidget(totals_);
  list_ = new QTreeWidget(this);
  list_->setColumnCount(3);
  list_->setHeaderHidden(true);
  list_->header()->setSectionResizeMode(kName, QHeaderView::ResizeToContents);
  list_->header()->setSectionResizeMode(kWhy, QHeaderView::Stretch);
  list_->header()->setSectionResizeMode(kBytes, QHeaderView::ResizeToContents);
  list_->header()->setStretchLastSection(false);
  list_->setIndentation(10);
  list_->setWordWrap(true);
  list_->setSelectionMode(QAbstractItemView::NoSelection);
  list_->setFocusPolicy(Qt::NoFocus);
  list_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  list_->setVerticalScrollMode(QAbstractItemView::ScrollPerPixel);
  layout->addWidget(list_, 1);

  connect(&workbench_, &Workbench::scene_changed, this, &PlanPanel::refresh);
  connect(&workbench_, &Workbench::pose_changed, this, [this] {  // meshes are refined as they move
    if (shown_topology_ != workbench_.session().topology_revision()) refresh();
  });
}

void PlanPanel::set_in_sight(bool in_sight) {
  in_sight_ = in_sight;
  refresh();
}

void PlanPanel::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  fit_reasons();
}

// A slider in motion comes here with every event: the list is made anew only when the plan has become another.
void PlanPanel::refresh() {
  if (!in_sight_) return;
  shown_topology_ = workbench_.session().topology_revision();
  StepPlan plan = workbench_.session().plan();
  if (plan == shown_) return;
  shown_ = std::move(plan);
  refresh_totals();
  fill();
}

void PlanPanel::refresh_totals() {
  const Session& session = workbench_.session();
  const std::size_t held = shown_.bytes_held();
  QString text = tr("<b>%1</b> held").arg(size_of(held));
  try {
    std::size_t available = session.engine().bytes_available();
    // The CPU engine has no bound of its own: what the system could give without swapping.
    if (available == std::numeric_limits<std::size_t>::max()) available = available_memory() + held;
    const double percent = available > 0 ? 100.0 * static_cast<double>(held) / static_cast<double>(available) : 100;
    const QString share = percent < 0.1 ? tr("less than 0.1%") : tr("%1%").arg(percent, 0, 'f', 1);
    text += tr(", %1 of %2").arg(share, size_of(available));
  } catch (const std::exception&) {
    // A device that was lost says so elsewhere; the plan holds all the same.
  }
  totals_->setText(text);
}

QTreeWidgetItem* PlanPanel::add_group(const QString& title, const QString& value, const QString& tip) {
  auto* group = new QTreeWidgetItem(list_, {title, {}, value});
  QFont bold = list_->font();
  bold.setBold(true);
  for (const int column : {kName, kBytes}) group->setFont(column, bold);
  for (const int column : {kName, kWhy, kBytes}) group->setToolTip(column, tip);
  group->setTextAlignment(kBytes, Qt::AlignRight | Qt::AlignVCenter);
  return group;
}

void PlanPanel::add_needed(const QString& title, const QString& tip, const char* what) {
  QTreeWidgetItem* group = add_group(title, size_of(bytes_of(shown_, what)), tip);
  for (const StepPlan::Item& item : shown_.items) {
    if (!item.needed || item.what != what) continue;
    auto* row = new QTreeWidgetItem(group, {text_of(item.name), text_of(item.why), size_of(item.bytes)});
    row->setForeground(kWhy, theme::shades().dim);
    row->setTextAlignment(kBytes, Qt::AlignRight | Qt::AlignVCenter);
    for (const int column : {kName, kWhy}) row->setToolTip(column, text_of(item.name + ": " + item.why));
  }
  group->setExpanded(true);
}

// Many things are left out for one reason: it stands above them, once.
void PlanPanel::add_left_out() {
  QTreeWidgetItem* group = add_group(tr("Left out"), {}, tr("Neither held nor computed, nor asked about in the step"));
  std::map<std::string, QTreeWidgetItem*> reasons;
  for (const StepPlan::Item& item : shown_.items) {
    if (item.needed) continue;
    QTreeWidgetItem*& reason = reasons[item.why];
    if (!reason) {
      reason = new QTreeWidgetItem(group, {text_of(item.why)});
      reason->setFirstColumnSpanned(true);
      reason->setForeground(kName, theme::shades().dim);
    }
    auto* row = new QTreeWidgetItem(reason, {text_of(item.name)});
    row->setFirstColumnSpanned(true);
    row->setDisabled(true);
  }
  group->setExpanded(true);
  for (const auto& [why, row] : reasons) row->setExpanded(true);
}

// A row that spans the columns does not wrap by itself.
void PlanPanel::fit_reasons() {
  const int groups = list_->topLevelItemCount();
  if (groups == 0) return;
  const QTreeWidgetItem* left_out = list_->topLevelItem(groups - 1);
  const int width = list_->viewport()->width() - 2 * list_->indentation() - 8;
  for (int n = 0; n < left_out->childCount(); ++n) {
    QTreeWidgetItem* reason = left_out->child(n);
    const QRect box =
        list_->fontMetrics().boundingRect(QRect(0, 0, width, 1000), Qt::TextWordWrap, reason->text(kName));
    reason->setSizeHint(kName, QSize(1, box.height() + 5));
  }
}

void PlanPanel::fill() {
  const int scrolled = list_->verticalScrollBar()->value();
  list_->setUpdatesEnabled(false);
  list_->clear();
  add_needed(tr("Held"), tr("Arrays that the scene keeps in the memory of what computes"), "array");
  add_needed(tr("Computed"), tr("Kernels, and the bytes that each reads and writes when it runs"), "kernel");
  add_left_out();
  fit_reasons();
  list_->verticalScrollBar()->setValue(scrolled);
  list_->setUpdatesEnabled(true);
}

}  // namespace simplexseg
