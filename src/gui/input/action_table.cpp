// SPDX-License-Identifier: Apache-2.0
#include "gui/input/action_table.h"

#include <QAction>
#include <QWidget>

#include "gui/input/key_map.h"
#include "gui/look/widgets.h"

namespace simplexseg {

ActionTable::ActionTable(QWidget& window) : QObject(&window) {
  for (const Binding& binding : bindings()) {
    if (binding.where != Where::Everywhere) continue;
    auto* action = new QAction(QString::fromUtf8(binding.title), this);
    action->setStatusTip(QString::fromUtf8(binding.help));
    window.addAction(action);
    actions_.emplace(binding.act, action);
  }
  show_keys();
  connect(&KeyMap::shared(), &KeyMap::changed, this, &ActionTable::show_keys);
}

void ActionTable::show_keys() {
  for (const auto& [act, action] : actions_) {
    const QString help = QString::fromUtf8(binding_of(act).help), key = key_text(act);
    action->setShortcut(KeyMap::shared().keys().key_of(act));
    set_tool_tip(action, key.isEmpty() ? help : QString("%1 (%2)").arg(help, key));
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
