// SPDX-License-Identifier: Apache-2.0
// How the simulation and each mesh fare, in the words that all parts of the window use.
#pragma once
#include <QString>
#include <cstddef>

namespace simplexseg {

class FrameLoop;
class Workbench;

enum class RunState { Nothing, Running, Learning, AtRest, Paused, Unsure, Leaking, Failed };

/// Learning: a field is being learned, and no mesh moves meanwhile. Failed goes before Leaking, that before Unsure,
/// that before the others; Nothing: there is no mesh.
RunState run_state(const Workbench& workbench, const FrameLoop& loop);
/// "running, 84 steps/s", "at rest" ...
QString text_of(RunState state, const FrameLoop& loop);

struct MeshState {
  QString text;
  bool is_warning = false;
};
/// Of the mesh at this place in the scene.
MeshState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh);
/// What it means that the mesh is in this state and what can be done; empty where there is nothing to say.
QString advice_of(const Workbench& workbench, std::size_t mesh);
/// "folded at 12 vertices", "inside out"; empty where the surface is sound.
QString faults_of(const Workbench& workbench, std::size_t mesh);

}  // namespace simplexseg
