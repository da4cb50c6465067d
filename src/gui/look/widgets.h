// SPDX-License-Identifier: Apache-2.0
// Small helpers of panels and menus.
#pragma once
#include <QIcon>
#include <QString>

#include "core/colour.h"

class QAction;
class QTableWidget;
class QWidget;

namespace simplexseg {

/// Enables a control, or disables it and shows the reason in its tooltip. Enabling restores the previous tooltip.
void set_enabled(QWidget* control, bool enabled, const QString& why_not);
void set_enabled(QAction* action, bool enabled, const QString& why_not);

/// Small square of one colour; `active`: with a rim in the text colour.
QIcon swatch(const Colour& colour, bool active = false);
/// Sets the tool tip that an entry has while it is enabled.
void set_tool_tip(QAction* action, const QString& tip);
/// Sets a style of the theme: "dim", "small" or "warning" for labels, "flat" or "raised" for buttons, "title" for
/// fields, "" for the default.
void set_role(QWidget* widget, const char* role);
/// Makes a table one of values: its cells are not edited, its headers are not highlighted, and its corner has a name.
void make_read_only(QTableWidget& table);
/// Readable title of a parameter name: "steps_per_level" -> "Steps per level".
QString words_of(const char* name);

/// Size of a window that fits, with its frame, into an area of the screen: `size`, reduced where necessary.
QSize size_within(const QSize& size, const QRect& area);
/// Shrinks a window that is not shown yet to the available area of its screen, which is small with a large scale factor
/// of the desktop, and moves it into that area if it has a position.
void fit_on_screen(QWidget& window);

}  // namespace simplexseg
