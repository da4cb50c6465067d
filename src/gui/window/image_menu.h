// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>

#include "session/mesh_images.h"

class QActionGroup;

namespace simplexseg {

class Workbench;

/// Menu of the images in which the active segmentation is computed (docs/layers.md): one main image, and further ones
/// that inform it.
class ImageMenu : public QMenu {
  Q_OBJECT
 public:
  ImageMenu(Workbench& workbench, QWidget* parent);

 private:
  void refresh();
  /// Adds an entry for an image; 0: the volume.
  void add(std::uint32_t image, const QString& name);
  void set(const MeshImages& images);

  Workbench& workbench_;
  QActionGroup* main_;
};

}  // namespace simplexseg
