// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/ask_and_save.h"

#include <QFileDialog>
#include <QFileInfo>

#include "gui/workbench/workbench.h"

namespace simplexseg {

void ask_and_save(QWidget* parent, Workbench& workbench, const SaveQuestion& question,
                  const std::function<void(const QString&)>& save) {
  QString chosen;
  QString path = QFileDialog::getSaveFileName(parent, question.title, question.offered, question.kinds, &chosen);
  if (path.isEmpty()) return;
  if (QFileInfo(path).suffix().isEmpty()) path += chosen.section('*', 1).section(')', 0, 0);
  try {
    save(path);
    workbench.say(Severity::Note, QObject::tr("Saved %1").arg(path));
  } catch (const std::exception& error) {
    workbench.say(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

}  // namespace simplexseg
