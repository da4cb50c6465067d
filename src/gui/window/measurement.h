// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QByteArray>

namespace simplexseg {

class MainWindow;

/// Runs the open scene in the window, which must be shown, and measures frames, steps, bytes read back from the device
/// and latencies. After one second of warm-up, the scene only runs for half of `seconds`; for the other half, a
/// boundary point is dragged in the axial view, by mouse events about every 30 ms through the event loop. Settled
/// meshes keep running. Returns JSON. A latency is measured from the time at which the event was due, so that it
/// includes the time in the queue. Throws Error if there is no mesh.
QByteArray measure(MainWindow& window, double seconds);

}  // namespace simplexseg
