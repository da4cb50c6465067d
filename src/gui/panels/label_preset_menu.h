// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>

namespace simplexseg {

class Workbench;

/// Menu of label presets: chooses the one of the scene. Lists the presets of the program and the files in folder().
class LabelPresetMenu : public QMenu {
  Q_OBJECT
 public:
  LabelPresetMenu(Workbench& workbench, QWidget* parent);
  /// Folder of the user's presets: simplexseg/labels in the user's configuration folder.
  static QString folder();

 private:
  void fill();
  void choose_file();

  Workbench& workbench_;
};

}  // namespace simplexseg
