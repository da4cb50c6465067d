// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>
#include <functional>

#include "session/scene.h"

namespace simplexseg {

class Workbench;

/// Settings by name: what a force panel and the simulation have, saved to files, and taken from them as one action.
class PresetMenu : public QMenu {
  Q_OBJECT
 public:
  /// `target`: the mesh that takes the settings, 0 for all.
  PresetMenu(Workbench& workbench, std::function<ItemId()> target, QWidget* parent);
  /// simplexseg/presets in the user's folder for settings.
  static QString folder();

  /// Settings of the active mesh and of the simulation. False, with a message, when the file cannot be written.
  bool save_to(const QString& path);
  /// False, with a message, when it is no preset.
  bool load_from(const QString& path);

 private:
  void fill();
  void choose_and_save();
  void choose_and_load();

  Workbench& workbench_;
  std::function<ItemId()> target_;
};

}  // namespace simplexseg
