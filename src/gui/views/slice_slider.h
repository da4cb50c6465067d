// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QSlider>

#include "gui/look/slice_geometry.h"

namespace simplexseg {

class Workbench;

/// Slider beside a slice view for the number of the slice. It moves the crosshair along the normal of the slice.
class SliceSlider : public QSlider {
 public:
  SliceSlider(Workbench& workbench, Orientation orientation, QWidget* parent);

 private:
  void refresh();

  Workbench& workbench_;
  Orientation orientation_;
};

}  // namespace simplexseg
