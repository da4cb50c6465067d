// SPDX-License-Identifier: Apache-2.0
// Small helpers that panels and menus share.
#pragma once
#include <QIcon>
#include <QString>

#include "core/colour.h"

class QAction;
class QWidget;

namespace simplexseg {

/// Enables a control, or greys it and says why in its tooltip. The tooltip it had comes back when it is enabled.
void set_enabled(QWidget* control, bool enabled, const QString& why_not);
void set_enabled(QAction* action, bool enabled, const QString& why_not);

/// A small square of one colour; `active`: with a bright rim.
QIcon swatch(const Colour& colour, bool active = false);
/// One of the looks that the theme knows for widgets of its kind: "dim", "small" or "warning" for labels, "flat" or
/// "raised" for buttons, "title" for fields; "": the usual one.
void set_role(QWidget* widget, const char* role);
/// "steps_per_level" -> "Steps per level".
QString words_of(const char* name);

}  // namespace simplexseg
