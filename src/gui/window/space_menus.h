// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>

namespace simplexseg {

class ActionTable;
class SpaceView;
class Workbench;

/// Menu of the planes that cut the 3D view.
class ClipMenu : public QMenu {
  Q_OBJECT
 public:
  ClipMenu(Workbench& workbench, SpaceView& space, ActionTable& actions, QWidget* parent);

 private:
  void toggle(int plane, bool on);
  void refresh();

  Workbench& workbench_;
  SpaceView& space_;
  ActionTable& actions_;
};

/// Menu of volume rendering in the 3D view.
class VolumeMenu : public QMenu {
  Q_OBJECT
 public:
  VolumeMenu(Workbench& workbench, SpaceView& space, ActionTable& actions, QWidget* parent);

 private:
  void refresh();

  Workbench& workbench_;
  SpaceView& space_;
  ActionTable& actions_;
  QAction* off_;
};

}  // namespace simplexseg
