// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QColor>

#include "gui/look/slice_geometry.h"

class QApplication;

namespace simplexseg::theme {

inline const QColor kText{222, 226, 230};
inline const QColor kDimText{150, 156, 164};
inline const QColor kDisabledText{104, 110, 118};
inline const QColor kSliceBackground{11, 12, 14};
inline const QColor kSpaceBackground{27, 30, 35};
inline const QColor kAccent{64, 140, 214};
inline const QColor kWarning{240, 173, 78};
inline const QColor kSelected{255, 221, 87};
// Bluish green and vermilion: told apart by the colour-blind (Okabe and Ito, Color universal design, 2008).
inline const QColor kInside{0, 158, 115};
inline const QColor kOutside{213, 94, 0};

/// Colour of a slice: its title, its trace in the other views and its frame in 3D.
QColor slice_colour(Orientation orientation);

/// Dark palette and the few style rules, for the whole program.
void apply(QApplication& application);

}  // namespace simplexseg::theme
