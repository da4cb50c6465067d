// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "cli/commands.h"
#include "io/scene/load_input.h"

namespace simplexseg {

/// Prints the computations and the memory of a step of the scene, and the estimated memory and time of a run. The
/// voxels of the volume are not used. `steps`: steps of the run; 0: until the meshes settle. `json`: prints JSON.
void print_plan(LoadedInput loaded, int steps, bool json, const Console& console);

}  // namespace simplexseg
