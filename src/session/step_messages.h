// SPDX-License-Identifier: Apache-2.0
// Messages about failed steps, one line each.
#pragma once
#include <string>

#include "session/scene.h"
#include "step/engine.h"

namespace simplexseg {

/// Message with segmentation, force and kind of a failure.
std::string text_of(const StepFailure& failure, const Scene& scene);
/// Message about steps that were undone and the reduced timestep.
std::string text_of(const TimestepCut& cut, const Scene& scene);

}  // namespace simplexseg
