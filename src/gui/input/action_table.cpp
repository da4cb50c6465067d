// SPDX-License-Identifier: Apache-2.0
#include "gui/input/action_table.h"

#include <QAction>
#include <QKeySequence>
#include <QWidget>

namespace simplexseg {

ActionTable::ActionTable(QWidget& window) : QObject(&window) {
  for (const Binding& binding : bindings()) {
    if (binding.where != Where::Everywhere) continue;
    const QKeySequence keys(QString::fromLatin1(binding.keys));
    auto* action = new QAction(QString::fromUtf8(binding.title), this);
    action->setShortcut(keys);
    action->setToolTip(
        QString("%1 (%2)").arg(QString::fromUtf8(binding.help), keys.toString(QKeySequence::NativeText)));
    action->setStatusTip(QString::fromUtf8(binding.help));
    window.addAction(action);
    actions_.emplace(binding.act, action);
  }
}

void ActionTable::on(Act act, std::function<void()> handler) {
  connect(actions_.at(act), &QAction::triggered, this, [handler = std::move(handler)] { handler(); });
}

void ActionTable::on_toggle(Act act, std::function<void(bool)> handler) {
  actions_.at(act)->setCheckable(true);
  connect(actions_.at(act), &QAction::triggered, this,
          [handler = std::move(handler)](bool checked) { handler(checked); });
}

}  // namespace simplexseg
