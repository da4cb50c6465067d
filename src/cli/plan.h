// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "cli/commands.h"
#include "io/load_input.h"

namespace simplexseg {

/// Prints what the step of a scene, whose voxels need not have been read, computes and holds, and what a run of it is
/// likely to need; `steps`: that are asked for, 0: until rest.
void print_plan(LoadedInput loaded, int steps, bool json, const Console& console);

}  // namespace simplexseg
