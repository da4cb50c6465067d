// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QColor>

#include "gui/look/slice_geometry.h"

class QApplication;

namespace simplexseg::theme {

// In the views, whose pictures are dark in every theme.
inline const QColor kText{222, 226, 230};
inline const QColor kDimText{150, 156, 164};
inline const QColor kSliceBackground{11, 12, 14};
inline const QColor kSpaceBackground{27, 30, 35};
inline const QColor kAccent{64, 140, 214};
inline const QColor kSelected{255, 221, 87};
// Bluish green and vermilion: told apart by the colour-blind (Okabe and Ito, Color universal design, 2008).
inline const QColor kInside{0, 158, 115};
inline const QColor kOutside{213, 94, 0};

/// Colour of a slice: its title, its trace in the other views and its frame in 3D.
QColor slice_colour(Orientation orientation);

/// What the user has chosen; Desktop: dark or light as the desktop says.
enum class Choice { Desktop, Dark, Light };
/// Sizes of text, in percent of the desktop's.
inline constexpr int kTextSizes[] = {100, 115, 130, 150};

/// The colours around the views. Text has a contrast of 4.5 or more on what it stands on, but where it is disabled.
struct Shades {
  QColor window, base, raised, hover, checked, header, line, card, active_card;
  QColor text, dim, disabled, accent, warning;
};
/// Of the theme that was applied last.
const Shades& shades();
bool is_dark();

/// Palette and the few style rules, for the whole program; may be called again at any time, but a size of text other
/// than before suits only windows that are made later.
void apply(QApplication& application, bool dark, int text_percent = 100);
/// Whether the desktop asks for dark windows; where it does not say: yes, as radiologists' workplaces have it.
bool desktop_is_dark();
/// A length of so many pixels at the usual size of text, as it is at the present one.
int scaled(int pixels);

}  // namespace simplexseg::theme
