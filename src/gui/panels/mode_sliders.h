// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QWidget>
#include <vector>

#include "session/scene.h"

class QSlider;
class QToolButton;

namespace simplexseg {

class Workbench;

/// Sliders of the first modes of a segmentation's model, in deviations: they set the shape from which its surface
/// starts (SetStartModes). The drag of a slider is one unit of undo.
class ModeSliders : public QWidget {
  Q_OBJECT
 public:
  ModeSliders(Workbench& workbench, QWidget* parent);
  /// Shows the start shape of a segmentation that has a model.
  void show_mesh(const MeshItem& item);

 private:
  void apply_values(int slider);
  void restore_values();

  Workbench& workbench_;
  ItemId mesh_ = 0;
  std::vector<QSlider*> sliders_;
  QToolButton* sphere_;
  bool dragged_ = false;  ///< whether the pressed slider has changed the shape
};

}  // namespace simplexseg
