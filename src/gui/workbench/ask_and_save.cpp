// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/ask_and_save.h"

#include <QFileDialog>
#include <QFileInfo>

#include "gui/look/qt_text.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

void ask_and_save(QWidget* parent, Workbench& workbench, const SaveDialog& dialog,
                  const std::function<void(const QString&)>& save) {
  QString chosen;
  QString path =
      local_path(QFileDialog::getSaveFileUrl(parent, dialog.title, url_of(dialog.suggestion), dialog.filters, &chosen));
  if (path.isEmpty()) return;
  if (QFileInfo(path).suffix().isEmpty()) path += chosen.section('*', 1).section(')', 0, 0);
  try {
    save(path);
    workbench.notify(Severity::Note, QObject::tr("Saved %1").arg(path));
  } catch (const std::exception& error) {
    workbench.notify(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

}  // namespace simplexseg
