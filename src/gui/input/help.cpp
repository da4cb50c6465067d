// SPDX-License-Identifier: Apache-2.0
#include "gui/input/help.h"

#include <QDialog>
#include <QDialogButtonBox>
#include <QMessageBox>
#include <QTextBrowser>
#include <QVBoxLayout>

#include "gui/input/bindings.h"
#include "gui/input/key_map.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {

QString trigger_text(const Binding& binding) {
  if (*binding.keys) {
    const QString key = key_text(binding.act);
    return key.isEmpty() ? QObject::tr("no key") : key;
  }
  QString text;
  if (binding.modifiers & Qt::ControlModifier) text += "Ctrl + ";
  if (binding.modifiers & Qt::ShiftModifier) text += "Shift + ";
  if (binding.modifiers & Qt::AltModifier) text += "Alt + ";
  switch (binding.mouse) {
    case Mouse::Left:
      return text + (binding.act == Act::ErasePoint || binding.act == Act::PickMesh ? "left click" : "left drag");
    case Mouse::Right:
      return text + "right drag";
    case Mouse::Middle:
      return text + "middle drag";
    case Mouse::RightClick:
      return text + "right click";
    case Mouse::DoubleClick:
      return text + "double click";
    case Mouse::Wheel:
      return text + "wheel";
    case Mouse::WheelOnPoint:
      return text + "wheel over a point";
    case Mouse::Move:
      return text + "move";
    case Mouse::None:
      break;
  }
  return text;
}

QString capitalised(QString text) {
  if (!text.isEmpty()) text[0] = text[0].toUpper();
  return text;
}

}  // namespace

QString bindings_html() {
  QString html;
  for (const Where where : {Where::Slices, Where::Space, Where::Everywhere}) {
    html += QString("<h3>%1</h3><table cellspacing='0' cellpadding='3'>").arg(where_name(where));
    for (const Binding& binding : bindings()) {
      if (binding.where != where) continue;
      html +=
          QString("<tr><td width='170'><b>%1</b></td><td>%2</td></tr>")
              .arg(capitalised(trigger_text(binding)).toHtmlEscaped(), QString::fromUtf8(binding.help).toHtmlEscaped());
    }
    html += "</table>";
  }
  return html;
}

void show_bindings(QWidget* parent) {
  auto* dialog = new QDialog(parent);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(QObject::tr("Keys and gestures"));
  dialog->resize(620, 640);
  fit_on_screen(*dialog);
  auto* layout = new QVBoxLayout(dialog);
  auto* text = new QTextBrowser(dialog);
  text->setHtml(bindings_html());
  layout->addWidget(text);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, dialog);
  QObject::connect(buttons, &QDialogButtonBox::rejected, dialog, &QDialog::reject);
  layout->addWidget(buttons);
  dialog->show();
}

void show_about(QWidget* parent, const QString& engine) {
  QMessageBox::about(parent, QObject::tr("About SimplexSeg"),
                     QObject::tr("<h3>SimplexSeg %1</h3>"
                                 "<p>Interactive segmentation of medical volumes with deformable 2-simplex meshes.</p>"
                                 "<p>Computing device: %2</p><p>Apache License 2.0. Not a medical device.</p>")
                         .arg(SIMPLEXSEG_VERSION, engine.toHtmlEscaped()));
}

}  // namespace simplexseg
