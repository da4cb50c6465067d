// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QByteArray>

namespace simplexseg {

class MainWindow;

/// Runs the open scene in the window, which must be shown, and measures frames, steps, bytes read back from the device
/// and latencies, as JSON. Parts of equal length:
/// - simulating: without input, after one second of warm-up. Meshes that settle continue to run, which keeps the load
///   constant.
/// - dragging: in addition, a boundary point is dragged in the axial view by mouse events, about every 30 ms, through
///   the event loop.
/// - correcting: meshes that settle sleep, as for a user. Once all have settled, or after a minute, the point is
///   dragged again.
/// - painting: like correcting, with strokes of paint of about a second each.
/// A latency is measured from the time at which the event was due, so it includes the time in the queue. Throws Error
/// if there is no mesh.
QByteArray measure(MainWindow& window, double seconds);

}  // namespace simplexseg
