// SPDX-License-Identifier: Apache-2.0
// Icons of the program. They are drawn as lines in the text colour when shown, so that they suit every scale and theme.
#pragma once
#include <QIcon>

namespace simplexseg {

// clang-format off
enum class Symbol {
  Open, Folder, Crosshair, ZoomPan, Seed, Box, Boundary, Inside, Outside, Brush, Eraser, Freeze, Ruler, Angle, Ellipse, Run, Pause, Step, Reset, Undo, Redo, WindowLevel,
  AutoContrast, Fit, Shown, Hidden, Locked, Unlocked, Menu
};
// clang-format on

/// Icon of a symbol. `colour`: for an icon on a coloured background; invalid: the text colour.
QIcon icon_of(Symbol symbol, const QColor& colour = {});

}  // namespace simplexseg
