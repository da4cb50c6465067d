// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/plan_panel.h"

#include <QHeaderView>
#include <QLabel>
#include <QScrollBar>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <limits>
#include <map>

#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/workbench/workbench.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

constexpr int kName = 0, kWhy = 1, kBytes = 2;

QString size_of(std::size_t bytes) { return text(format_bytes(static_cast<double>(bytes))); }

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
  totals_->setToolTip(tr("Memory used by this scene, as a share of the memory available on the computing device"));
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

void PlanPanel::set_on_screen(bool on_screen) {
  on_screen_ = on_screen;
  refresh();
}

void PlanPanel::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  fit_reasons();
}

// Called for each event of a slider drag, so the list is rebuilt only when the plan has changed.
void PlanPanel::refresh() {
  if (!on_screen_) return;
  shown_topology_ = workbench_.session().topology_revision();
  StepPlan plan = workbench_.session().plan();
  if (plan == shown_) return;
  shown_ = std::move(plan);
  refresh_totals();
  fill();
}

void PlanPanel::refresh_totals() {
  const Session& session = workbench_.session();
  const std::size_t held = shown_.bytes_allocated();
  QString text = tr("<b>%1</b> in use").arg(size_of(held));
  try {
    std::size_t available = session.engine().bytes_available();
    // The CPU engine has no limit: the memory that the system can provide without swapping is shown instead.
    if (available == std::numeric_limits<std::size_t>::max()) available = available_memory() + held;
    const double percent = available > 0 ? 100.0 * static_cast<double>(held) / static_cast<double>(available) : 100;
    const QString share = percent < 0.1 ? tr("less than 0.1%") : tr("%1%").arg(percent, 0, 'f', 1);
    text += tr(", %1 of %2").arg(share, size_of(available));
  } catch (const std::exception&) {
    // A lost device is reported elsewhere; the plan stays valid.
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
    auto* row = new QTreeWidgetItem(group, {text(item.name), text(item.why), size_of(item.bytes)});
    row->setForeground(kWhy, theme::shades().dim);
    row->setTextAlignment(kBytes, Qt::AlignRight | Qt::AlignVCenter);
    for (const int column : {kName, kWhy}) row->setToolTip(column, text(item.name + ": " + item.why));
  }
  group->setExpanded(true);
}

// Groups the skipped items by their reason.
void PlanPanel::add_skipped() {
  QTreeWidgetItem* group = add_group(tr("Not needed"), {}, tr("Neither stored nor computed with the current settings"));
  std::map<std::string, QTreeWidgetItem*> reasons;
  for (const StepPlan::Item& item : shown_.items) {
    if (item.needed) continue;
    QTreeWidgetItem*& reason = reasons[item.why];
    if (!reason) {
      reason = new QTreeWidgetItem(group, {text(item.why)});
      reason->setFirstColumnSpanned(true);
      reason->setForeground(kName, theme::shades().dim);
    }
    auto* row = new QTreeWidgetItem(reason, {text(item.name)});
    row->setFirstColumnSpanned(true);
    row->setDisabled(true);
  }
  group->setExpanded(true);
  for (const auto& [why, row] : reasons) row->setExpanded(true);
}

// Sets the heights of rows that span all columns, because Qt does not wrap their text.
void PlanPanel::fit_reasons() {
  const int groups = list_->topLevelItemCount();
  if (groups == 0) return;
  const QTreeWidgetItem* skipped = list_->topLevelItem(groups - 1);
  const int width = list_->viewport()->width() - 2 * list_->indentation() - 8;
  for (int n = 0; n < skipped->childCount(); ++n) {
    QTreeWidgetItem* reason = skipped->child(n);
    const QRect box =
        list_->fontMetrics().boundingRect(QRect(0, 0, width, 1000), Qt::TextWordWrap, reason->text(kName));
    reason->setSizeHint(kName, QSize(1, box.height() + 5));
  }
}

void PlanPanel::fill() {
  const int scrolled = list_->verticalScrollBar()->value();
  list_->setUpdatesEnabled(false);
  list_->clear();
  add_needed(tr("In memory"), tr("Arrays that the scene keeps in the memory of the computing device"), "array");
  add_needed(tr("Computed"), tr("Kernels of a step, with the bytes that each reads and writes"), "kernel");
  add_skipped();
  fit_reasons();
  list_->verticalScrollBar()->setValue(scrolled);
  list_->setUpdatesEnabled(true);
}

}  // namespace simplexseg
