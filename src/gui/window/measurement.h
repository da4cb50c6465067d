// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QByteArray>

namespace simplexseg {

class MainWindow;

/// Runs the open scene in the window, which must be shown, and measures frames, steps, bytes read back from the device
/// and latencies. After one second of warm-up the scene only runs for half of `seconds`; for the other half a boundary
/// point is dragged in the axial view, by mouse events about every 30 ms through the event loop. Settled meshes keep
/// running. Returns JSON; a latency starts when the event was due, so that it includes the waiting time. Throws Error
/// when there is no mesh.
QByteArray measure(MainWindow& window, double seconds);

}  // namespace simplexseg
