// SPDX-License-Identifier: Apache-2.0
// The program's own icons, drawn when they are shown, as lines in the colour of the text: they suit every scale and
// every theme.
#pragma once
#include <QIcon>

namespace simplexseg {

// clang-format off
enum class Symbol {
  Open, Folder, Crosshair, ZoomPan, Seed, Boundary, Inside, Outside, Run, Pause, Step, Reset, Undo, Redo, WindowLevel,
  AutoContrast, Fit, Shown, Hidden, Locked, Unlocked, Menu
};
// clang-format on

/// `colour`: for one that stands on a ground of its own; none: that of the text.
QIcon icon_of(Symbol symbol, const QColor& colour = {});

}  // namespace simplexseg
