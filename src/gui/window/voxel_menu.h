// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>

#include "session/voxel_edit.h"

namespace simplexseg {

class Workbench;

/// Menu of the edits of voxels (session/voxel_edit.h) of the active segmentation. Asks for the size of an edit, and
/// lists the other segmentations for those that use one.
class VoxelMenu : public QMenu {
  Q_OBJECT
 public:
  VoxelMenu(Workbench& workbench, QWidget* parent);

 private:
  void add_edit(const VoxelEditInfo& info);
  void ask_size(const VoxelEditInfo& info);
  void list_others(QMenu& menu, VoxelEdit edit);
  void enable();

  Workbench& workbench_;
};

}  // namespace simplexseg
