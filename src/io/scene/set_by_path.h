// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// Applies an assignment "meshes.NAME.FORCE.PARAMETER=V", "forces.FORCE.PARAMETER=V" (all meshes and new ones) or
/// "simulation.PARAMETER=V". Throws Error without changing the scene if the path is unknown or the value is invalid.
void set_by_path(Scene& scene, const std::string& assignment);

}  // namespace simplexseg
