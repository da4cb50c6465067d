// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/parameter_help.h"

#include <QEvent>
#include <QVariant>

#include "gui/look/widgets.h"
#include "gui/panels/parameter_row.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {

QString help_of(const ParameterInfo& info) {
  const QString unit = *info.unit ? ' ' + QString::fromUtf8(info.unit) : QString();
  const auto text = [&info](float value) { return QString::fromStdString(parameter_to_text(info, value)); };
  QString help = QString::fromUtf8(info.doc);
  if (!help.endsWith('.')) help += '.';
  help += ParameterHelp::tr(" Default %1%2").arg(text(info.default_value), unit);
  if (info.kind != ParameterKind::Choice)
    help += ParameterHelp::tr(", from %1 to %2%3").arg(text(info.minimum), text(info.maximum), unit);
  return help + '.';
}

ParameterHelp::ParameterHelp(QWidget* parent) : QLabel(parent) {
  setObjectName("parameter_help");
  set_role(this, "small");
  setWordWrap(true);
  setAlignment(Qt::AlignLeft | Qt::AlignTop);
  setFixedHeight(4 * fontMetrics().lineSpacing() + 4);  // constant, so that the parameters do not move
  setText(tr("Point at a parameter, or move to it with Tab, to read its description."));
}

void ParameterHelp::watch(ParameterRow& row, const QString& title) {
  const QString text = "<b>" + title.toHtmlEscaped() + "</b>: " + help_of(row.info()).toHtmlEscaped();
  row.setProperty("help", text);
  row.installEventFilter(this);
  for (QWidget* part : row.findChildren<QWidget*>()) {
    part->setProperty("help", text);
    part->installEventFilter(this);
  }
}

bool ParameterHelp::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::Enter || event->type() == QEvent::FocusIn) setText(watched->property("help").toString());
  return QLabel::eventFilter(watched, event);
}

}  // namespace simplexseg
