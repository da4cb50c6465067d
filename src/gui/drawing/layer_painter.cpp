// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/layer_painter.h"

#include <GL/glew.h>

namespace simplexseg {

void LayerPainter::draw(const Projection& projection, const LayerSlice& slice, const LayerCover& cover) const {
  const Program& program = quad_.program();
  const LayerItem& item = slice.item;
  const double low = (item.level - item.window / 2) / item.scale, width = item.window / item.scale;
  program.set("values", Eigen::Vector2f(static_cast<float>(low), static_cast<float>(width)));
  program.set("colour_map", static_cast<float>(item.colour_map));
  program.set("opacity", cover.mode == LayerMode::Blend ? item.opacity : 1.0f);
  program.set("mode", static_cast<float>(cover.mode));
  program.set("divider_px", cover.divider_px);
  program.set("square_px", cover.square_px);
  quad_.draw(projection, slice.grid, slice.texture);
}

}  // namespace simplexseg
