// SPDX-License-Identifier: Apache-2.0
#include "gui/window/name_popup.h"

#include <QApplication>
#include <QCursor>
#include <QHBoxLayout>
#include <QListWidget>
#include <QMouseEvent>
#include <algorithm>
#include <utility>

#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/workbench/name_line.h"
#include "gui/workbench/naming.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

NamePopup::NamePopup(Workbench& workbench, QWidget& area) : QFrame(&area), workbench_(workbench), area_(area) {
  setObjectName("name_popup");
  setAutoFillBackground(true);
  setFrameShape(QFrame::StyledPanel);
  line_ = new NameLine([this] { return offered_labels(workbench_.scene()); }, this);
  line_->setPlaceholderText(tr("Name, e.g. two letters"));
  line_->setAccessibleName(tr("Name of the new segmentation"));
  line_->setToolTip(tr("Enter accepts, Esc keeps the name"));
  line_->setMinimumWidth(theme::scaled(190));
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(4, 4, 4, 4);
  row->addWidget(line_);
  hide();
  connect(line_, &NameLine::chosen, this, [this](const PresetLabel& label) {
    const ItemId mesh = std::exchange(mesh_, 0);
    if (mesh && workbench_.scene().find_mesh(mesh)) workbench_.apply(naming_command(workbench_.scene(), mesh, label));
  });
  connect(line_, &QLineEdit::editingFinished, this, [this] { close_with(line_->text().trimmed()); });
  connect(&workbench_, &Workbench::mesh_placed, this, [this] {
    if (!workbench_.scene().labels.preset.empty()) ask();
  });
  connect(&workbench_, &Workbench::restarted, this, [this] { close_with({}); });
}

void NamePopup::ask() {
  if (!workbench_.active_mesh()) return;
  mesh_ = workbench_.view.active_mesh;
  line_->clear();
  adjustSize();
  constexpr int kBeside = 18;  // distance from the mouse, logical pixels
  const QPoint mouse = area_.mapFromGlobal(QCursor::pos());
  const QPoint at = area_.rect().contains(mouse) ? mouse + QPoint(kBeside, kBeside)
                                                 : QPoint((area_.width() - width()) / 2, area_.height() / 8);
  move(std::clamp(at.x(), 0, std::max(0, area_.width() - width())),
       std::clamp(at.y(), 0, std::max(0, area_.height() - height())));
  show();
  raise();
  line_->setFocus(Qt::OtherFocusReason);
  QApplication::instance()->installEventFilter(this);
}

void NamePopup::close_with(const QString& typed) {
  const ItemId mesh = std::exchange(mesh_, 0);
  QApplication::instance()->removeEventFilter(this);
  const bool named = mesh && !typed.isEmpty() && workbench_.scene().find_mesh(mesh);
  if (named) workbench_.apply(naming_command(workbench_.scene(), mesh, typed.toStdString()));
  if (isHidden()) return;
  line_->clear();
  hide();
}

// A press outside closes the field, also on a widget that does not take the focus.
bool NamePopup::eventFilter(QObject* watched, QEvent* event) {
  const bool press = event->type() == QEvent::MouseButtonPress && watched->isWidgetType();
  if (!press || isHidden()) return false;
  const QPoint at = static_cast<QMouseEvent*>(event)->globalPosition().toPoint();
  const auto contains = [&](const QWidget& widget) {
    return widget.isVisible() && widget.rect().contains(widget.mapFromGlobal(at));
  };
  if (!contains(*this) && !contains(line_->list())) close_with(line_->text().trimmed());
  return false;
}

}  // namespace simplexseg
