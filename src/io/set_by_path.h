// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// Applies "meshes.NAME.FORCE.PARAMETER=V", "forces.FORCE.PARAMETER=V" (every mesh) or "simulation.PARAMETER=V". Throws
/// Error, with nothing changed, where there is no such path or the value is none of the parameter's.
void set_by_path(Scene& scene, const std::string& assignment);

}  // namespace simplexseg
