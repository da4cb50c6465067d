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
  list_->setAccessibleName(tr("History"));
  list_->setToolTip(tr("Click to return to the state after this action"));
  list_->setUniformItemSizes(true);
  list_->setTextElideMode(Qt::ElideRight);
  list_->setMinimumWidth(theme::scaled(180));
  layout->addWidget(list_, 1);
  auto* hint = new QLabel(tr("Click an action to return to the state directly after it. Actions below the arrow are "
                             "undone; your next change deletes them."),
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
  const auto add = [this](const QString& text, bool applied) {
    auto* item = new QListWidgetItem(text, list_);
    if (!applied) item->setForeground(theme::shades().dim);
    QFont font = item->font();
    font.setItalic(!applied);
    item->setFont(font);
    item->setToolTip(text);
  };
  add(tr("(start)"), true);
  for (const std::string& name : done) add(QString::fromStdString(name), true);
  for (const std::string& name : undone) add(QString::fromStdString(name), false);
  QListWidgetItem* current = list_->item(static_cast<int>(done.size()));
  current->setText(current->text() + "   " + tr("\u25c0 now"));
  QFont font = current->font();
  font.setBold(true);
  current->setFont(font);
  list_->setCurrentItem(current);
  list_->scrollToItem(current);
}

}  // namespace simplexseg
