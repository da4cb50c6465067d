// SPDX-License-Identifier: Apache-2.0
// State of the simulation and of each mesh, with the texts that the whole window uses.
#pragma once
#include <QString>
#include <cstddef>

namespace simplexseg {

class FrameLoop;
class Workbench;

/// State of a mesh, or of the simulation, in the order of precedence. Nothing: there is no mesh. Failed: the last steps
/// failed. Spreading, Doubtful: the segmentation needs more marks. Pending: marks are not applied, because the user has
/// cancelled the update. Solving: its field is being computed. Waiting: its field follows that of another mesh.
/// Overlapping: the surface overlaps itself and does not move. Settled: the simulation runs, but the mesh does not
/// move.
enum class RunState {
  Nothing,
  Failed,
  Spreading,
  Doubtful,
  Pending,
  Solving,
  Running,
  Waiting,
  Overlapping,
  Paused,
  Settled,
  Locked
};

/// Whether the simulation runs and has not settled; Pause is then offered, otherwise Run.
bool is_moving(const Workbench& workbench, const FrameLoop& loop);
/// State of the mesh with index `mesh` in the scene.
RunState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh);
/// State of the simulation: Nothing, Failed, or the mesh_state() of highest precedence.
RunState run_state(const Workbench& workbench, const FrameLoop& loop);
/// Text of a state, such as "running" or "solving 40%". `solving_percent`: Workbench::solving_percent().
QString text_of(RunState state, int solving_percent);
/// Whether a state requires an action of the user.
bool is_warning(RunState state);
/// Explanation of the state of the mesh, with advice; empty if there is nothing to explain.
QString advice_of(const Workbench& workbench, std::size_t mesh);
/// Faults of the surface, such as "the surface overlaps itself in 12 places"; empty if there are none.
QString faults_of(const Workbench& workbench, std::size_t mesh);

}  // namespace simplexseg
