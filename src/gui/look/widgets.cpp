// SPDX-License-Identifier: Apache-2.0
#include "gui/look/widgets.h"

#include <QAbstractButton>
#include <QAction>
#include <QHeaderView>
#include <QPainter>
#include <QPixmap>
#include <QScreen>
#include <QStyle>
#include <QTableWidget>
#include <QVariant>
#include <QWidget>

#include "gui/look/theme.h"

namespace simplexseg {
namespace {
constexpr const char* kSavedTip = "tooltip_when_enabled";

template <class Control>
void set_enabled_of(Control* control, bool enabled, const QString& why_not) {
  if (!control->property(kSavedTip).isValid()) control->setProperty(kSavedTip, control->toolTip());
  control->setEnabled(enabled);
  const QString tip = enabled ? control->property(kSavedTip).toString() : why_not;
  if (control->toolTip() != tip) control->setToolTip(tip);
}
}  // namespace

void set_enabled(QWidget* control, bool enabled, const QString& why_not) { set_enabled_of(control, enabled, why_not); }
void set_enabled(QAction* action, bool enabled, const QString& why_not) { set_enabled_of(action, enabled, why_not); }

void set_tool_tip(QAction* action, const QString& tip) {
  const bool saved = action->property(kSavedTip).isValid();
  if (saved) action->setProperty(kSavedTip, tip);
  if (!saved || action->isEnabled()) action->setToolTip(tip);
}

void set_role(QWidget* widget, const char* role) {
  if (widget->property("role").toString() == QLatin1String(role)) return;
  widget->setProperty("role", QString::fromLatin1(role));
  widget->style()->unpolish(widget);
  widget->style()->polish(widget);
}

QIcon swatch(const Colour& colour, bool active) {
  QPixmap pixmap(28, 28);
  pixmap.fill(Qt::transparent);
  pixmap.setDevicePixelRatio(2);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setBrush(QColor(colour.red, colour.green, colour.blue));
  painter.setPen(active ? QPen(theme::shades().text, 1.5) : QPen(QColor(0, 0, 0, 120), 1));
  painter.drawRoundedRect(QRectF(1, 1, 12, 12), 2.5, 2.5);
  return QIcon(pixmap);
}

void make_read_only(QTableWidget& table) {
  for (auto* corner : table.findChildren<QAbstractButton*>())
    corner->setAccessibleName(QObject::tr("Corner of the table"));
  table.setEditTriggers(QAbstractItemView::NoEditTriggers);
  table.setWordWrap(false);
  for (QHeaderView* header : {table.horizontalHeader(), table.verticalHeader()}) header->setHighlightSections(false);
}

QString words_of(const char* name) {
  QString words = QString::fromLatin1(name).replace('_', ' ');
  if (!words.isEmpty()) words[0] = words[0].toUpper();
  return words;
}

QSize size_within(const QSize& size, const QRect& area) {
  constexpr int kFrame = 8, kTitle = 40;  // logical pixels; the frame is not known before the window is shown
  return size.boundedTo(area.size() - QSize(2 * kFrame, kTitle + kFrame)).expandedTo({1, 1});
}

void fit_on_screen(QWidget& window) {
  const QScreen* const screen = window.screen();
  if (!screen || window.isMaximized() || window.isFullScreen()) return;
  const QRect area = screen->availableGeometry();
  window.resize(size_within(window.size(), area));
  if (!window.testAttribute(Qt::WA_Moved) || area.contains(window.geometry())) return;
  QRect place = window.geometry();
  place.moveCenter(area.center());
  window.move(place.topLeft());
}

}  // namespace simplexseg
