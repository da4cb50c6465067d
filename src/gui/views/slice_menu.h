// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QPointF>
#include <functional>

#include "session/scene.h"

class QPoint;

namespace simplexseg {

class MeasureTool;
class SliceView;
class Workbench;

/// Shows the context menu of a position in a slice view: points, measurements, meshes. `add_point`: adds a point of a
/// kind there.
void show_slice_menu(Workbench& workbench, SliceView& view, MeasureTool& measure_tool, const QPointF& pixel,
                     const QPoint& global, const std::function<void(MarkKind)>& add_point);

}  // namespace simplexseg
