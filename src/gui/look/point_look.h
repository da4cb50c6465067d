// SPDX-License-Identifier: Apache-2.0
// How points of the three kinds are told apart.
#pragma once
#include <QColor>
#include <QIcon>
#include <QString>

#include "core/colour.h"
#include "session/scene.h"

namespace simplexseg {

/// "Boundary", "Inside" or "Outside".
QString title_of(MarkKind kind);
/// What the kind's handle carries besides its colour: shapes say the kind to those who do not see the colours.
enum class Glyph { Plain, Plus, Minus };
Glyph glyph_of(MarkKind kind);
/// A boundary point has the colour of its mesh.
QColor colour_of(MarkKind kind, const Colour& mesh);
/// The handle, for lists.
QIcon handle_icon(MarkKind kind, const Colour& mesh);

}  // namespace simplexseg
