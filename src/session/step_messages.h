// SPDX-License-Identifier: Apache-2.0
// What the user is told of steps that failed: one line each.
#pragma once
#include <string>

#include "session/scene.h"
#include "step/engine.h"

namespace simplexseg {

/// Names the mesh and the force of a failure, and says what it did.
std::string text_of(const StepFailure& failure, const Scene& scene);
std::string text_of(const TimestepCut& cut, const Scene& scene);

}  // namespace simplexseg
