// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QColor>

#include "gui/look/slice_geometry.h"

class QApplication;

namespace simplexseg::theme {

// Colours of the views, whose images are dark in every theme.
inline const QColor kText{222, 226, 230};
inline const QColor kDimText{150, 156, 164};
inline const QColor kSliceBackground{11, 12, 14};
inline const QColor kSpaceBackground{27, 30, 35};
inline const QColor kAccent{64, 140, 214};
inline const QColor kSelected{255, 221, 87};
inline const QColor kMeasurement{115, 222, 255};
// Bluish green and vermilion: distinguishable by the colour-blind (Okabe and Ito, Color universal design, 2008).
inline const QColor kInside{0, 158, 115};
inline const QColor kOutside{213, 94, 0};
inline const QColor kFrozen{140, 205, 255};

/// Colour of a slice's title, of its trace in the other views and of its frame in 3D.
QColor slice_colour(Orientation orientation);

/// Theme chosen by the user; Desktop: the setting of the desktop.
enum class Choice { Desktop, Dark, Light };
/// Text sizes, in percent of the text size of the desktop.
inline constexpr int kTextSizes[] = {100, 115, 130, 150};

/// Colours around the views. Enabled text has a contrast of 4.5 or more against its background.
struct Shades {
  QColor window, base, raised, hover, checked, header, line, card, active_card;
  QColor text, dim, disabled, accent, warning;
};
/// Colours of the theme that was applied last.
const Shades& shades();
bool is_dark();

/// Applies palette and style rules to the whole program. It may be called again at any time, but a new text size fits
/// only windows that are created afterwards.
void apply(QApplication& application, bool dark, int text_percent = 100);
/// Returns true if the desktop prefers dark windows, or has no preference: radiologists' workplaces are dark.
bool desktop_is_dark();
/// Length in pixels at the current text size, from its length at the default text size.
int scaled(int pixels);

}  // namespace simplexseg::theme
