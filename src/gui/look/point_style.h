// SPDX-License-Identifier: Apache-2.0
// Title, glyph and colour of the three kinds of points.
#pragma once
#include <QColor>
#include <QIcon>
#include <QString>

#include "core/colour.h"
#include "session/scene.h"

namespace simplexseg {

/// Title of a kind: "Boundary", "Inside" or "Outside".
QString title_of(MarkKind kind);
/// Title of the kind, and whether it is a stroke, lasso or paint: "Inside", "Inside stroke", "Lasso, inside, 14
/// strokes", "Paint", "Eraser".
QString title_of(const UserPoint& point);
/// Sign on a point's handle, which distinguishes the kinds without colour.
enum class Glyph { Plain, Plus, Minus };
QString title_of(VoxelEdit edit);
Glyph glyph_of(MarkKind kind);
/// Colour of a point's handle; a boundary point has the colour of its mesh.
QColor colour_of(MarkKind kind, const Colour& mesh);
/// Whether a point belongs to a locked mesh, and so cannot be moved, changed or deleted.
bool is_locked(const Scene& scene, ItemId point);
/// Icon of the handle, for lists.
QIcon handle_icon(MarkKind kind, const Colour& mesh);

}  // namespace simplexseg
