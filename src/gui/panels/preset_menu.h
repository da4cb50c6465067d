// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>
#include <functional>

#include "session/scene.h"

namespace simplexseg {

class Workbench;

/// Menu of presets: saves the settings of the forces and of the simulation to files, and applies them as one action.
class PresetMenu : public QMenu {
  Q_OBJECT
 public:
  /// `target` returns the mesh to which settings are applied; 0 for all meshes.
  PresetMenu(Workbench& workbench, std::function<ItemId()> target, QWidget* parent);
  /// Folder of the presets: simplexseg/presets in the user's configuration folder.
  static QString folder();

  /// Saves the settings of the active mesh and of the simulation. Returns false without an active mesh, and, with a
  /// message, if the file cannot be written.
  bool save_to(const QString& path);
  /// Applies a preset. Returns false, with a message, if the file is not a preset or cannot be applied.
  bool load_from(const QString& path);

 private:
  void fill();
  void choose_and_save();
  void choose_and_load();

  Workbench& workbench_;
  std::function<ItemId()> target_;
};

}  // namespace simplexseg
