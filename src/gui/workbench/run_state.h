// SPDX-License-Identifier: Apache-2.0
// State of the simulation and of each mesh, with the texts that the whole window uses.
#pragma once
#include <QString>
#include <cstddef>

namespace simplexseg {

class FrameLoop;
class Workbench;

enum class RunState { Nothing, Running, Solving, Settled, Paused, Doubtful, Spreading, Failed };

/// State of the simulation. Nothing: there is no mesh. Solving: a field is being computed, and no mesh moves meanwhile.
/// Order of precedence: Nothing, Failed, Spreading, Doubtful, Paused, Solving, Settled, Running.
RunState run_state(const Workbench& workbench, const FrameLoop& loop);
/// Text of a state, such as "running" or "solving 40%". `solving_percent`: Workbench::solving_percent().
QString text_of(RunState state, int solving_percent);

struct MeshState {
  QString text;
  bool is_warning = false;
};
/// State of the mesh with index `mesh` in the scene.
MeshState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh);
/// Explanation of the state of the mesh, with advice; empty if there is nothing to explain.
QString advice_of(const Workbench& workbench, std::size_t mesh);
/// Faults of the surface, such as "the surface overlaps itself in 12 places"; empty if there are none.
QString faults_of(const Workbench& workbench, std::size_t mesh);

}  // namespace simplexseg
