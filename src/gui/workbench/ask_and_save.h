// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QString>
#include <functional>

class QWidget;

namespace simplexseg {

class Workbench;

struct SaveQuestion {
  QString title;
  QString offered;  ///< name or path
  QString kinds;    ///< as QFileDialog takes filters: "Picture (*.png);;Table (*.csv)"
};

/// Asks for a file, hands it to `save`, and tells the user what came of it. A name without an ending gets that of the
/// kind that was chosen.
void ask_and_save(QWidget* parent, Workbench& workbench, const SaveQuestion& question,
                  const std::function<void(const QString& path)>& save);

}  // namespace simplexseg
