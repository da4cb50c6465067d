// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QString>
#include <functional>

class QWidget;

namespace simplexseg {

class Workbench;

/// Contents of a dialog for saving a file.
struct SaveDialog {
  QString title;
  QString suggestion;  ///< suggested name or path
  QString filters;     ///< in the syntax of QFileDialog: "Picture (*.png);;Table (*.csv)"
};

/// Asks the user for a file, passes its path to `save`, and reports success or failure. A name without extension gets
/// the extension of the chosen filter.
void ask_and_save(QWidget* parent, Workbench& workbench, const SaveDialog& dialog,
                  const std::function<void(const QString& path)>& save);

}  // namespace simplexseg
