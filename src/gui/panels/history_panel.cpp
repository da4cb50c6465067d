// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/history_panel.h"

#include <QLabel>
#include <QListWidget>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

HistoryPanel::HistoryPanel(Workbench& workbench, QWidget* parent) : QWidget(parent), workbench_(workbench) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  list_ = new QListWidget(this);
  list_->setObjectName("history");
  list_->setAccessibleName(tr("What was done"));
  list_->setToolTip(tr("Click: go to just after this action"));
  list_->setUniformItemSizes(true);
  list_->setTextElideMode(Qt::ElideRight);
  list_->setMinimumWidth(theme::scaled(180));
  layout->addWidget(list_, 1);
  auto* hint = new QLabel(tr("A click goes to just after an action. What is below the mark was taken back, and stays "
                             "until you do something else."),
                          this);
  hint->setWordWrap(true);
  set_role(hint, "small");
  layout->addWidget(hint);
  const auto go = [this](const QListWidgetItem* item) {
    if (!item || going_) return;
    const std::size_t row = static_cast<std::size_t>(list_->row(item));
    going_ = true;
    workbench_.go_to_action(row);
    going_ = false;
    refresh();
  };
  connect(list_, &QListWidget::itemClicked, this, go);
  connect(list_, &QListWidget::itemActivated, this, go);
  connect(&workbench_, &Workbench::scene_changed, this, &HistoryPanel::refresh);
}

void HistoryPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  refresh();
}

void HistoryPanel::refresh() {
  if (going_ || !isVisible()) return;
  const QSignalBlocker blocker(list_);
  const std::vector<std::string> done = workbench_.session().history().undo_names();
  const std::vector<std::string> undone = workbench_.session().history().redo_names();
  list_->clear();
  const auto add = [this](const QString& text, bool in_force) {
    auto* item = new QListWidgetItem(text, list_);
    if (!in_force) item->setForeground(theme::shades().dim);
    QFont font = item->font();
    font.setItalic(!in_force);
    item->setFont(font);
    item->setToolTip(text);
  };
  add(tr("(before)"), true);
  for (const std::string& name : done) add(QString::fromStdString(name), true);
  for (const std::string& name : undone) add(QString::fromStdString(name), false);
  QListWidgetItem* present = list_->item(static_cast<int>(done.size()));
  present->setText(present->text() + "   " + tr("\u25c0 now"));
  QFont font = present->font();
  font.setBold(true);
  present->setFont(font);
  list_->setCurrentItem(present);
  list_->scrollToItem(present);
}

}  // namespace simplexseg
