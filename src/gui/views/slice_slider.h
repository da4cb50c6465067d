// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QSlider>

#include "gui/look/slice_geometry.h"

namespace simplexseg {

class Workbench;

/// Beside a slice: which of all slices it is. Moves the crosshair along the slices' normal.
class SliceSlider : public QSlider {
 public:
  SliceSlider(Workbench& workbench, Orientation orientation, QWidget* parent);

 private:
  void refresh();

  Workbench& workbench_;
  Orientation orientation_;
};

}  // namespace simplexseg
