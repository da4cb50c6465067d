// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "gui/drawing/layer_slices.h"
#include "gui/drawing/painters.h"
#include "gui/look/view_state.h"

namespace simplexseg {

/// Part of a view in which layers cover the volume.
struct LayerCover {
  LayerMode mode = LayerMode::Blend;
  float divider_px = 0;  ///< Swipe: left edge of the layers, device pixels
  float square_px = 1;   ///< Checkerboard: side of a square, device pixels
};

/// Painter of a layer over a slice of the volume. A blend has the layer's opacity; with a coloured map, the values of
/// the lowest quarter of the window become transparent towards its low end. Checkerboard and swipe cover the volume.
class LayerPainter {
 public:
  void create() { quad_.create("slice.vert", "layer.frag"); }
  void destroy() { quad_.destroy(); }
  void draw(const Projection& projection, const LayerSlice& slice, const LayerCover& cover) const;

 private:
  SliceQuad quad_;
};

}  // namespace simplexseg
