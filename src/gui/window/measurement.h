// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QByteArray>

namespace simplexseg {

class MainWindow;

/// Runs the scene that is open in the window, which must be shown, and measures after a first second: for half of
/// `seconds` it only runs, for the other half an attraction point is dragged in the axial view, by mouse events that
/// come through the event loop about every 30 ms. A mesh at rest is kept running. Frames, steps, bytes read back from
/// the device and latencies as JSON; a latency counts from when the event was due, so what it waited for is in it.
/// Throws Error when there is no mesh.
QByteArray measure(MainWindow& window, double seconds);

}  // namespace simplexseg
