// SPDX-License-Identifier: Apache-2.0
// Messages about failed steps and ranges of intensities, each of one line.
#pragma once
#include <string>

#include "session/scene.h"
#include "step/engine.h"

namespace simplexseg {

/// Message that names segmentation and force, and describes the failure.
std::string text_of(const StepFailure& failure, const Scene& scene);
/// Message about a failure after which steps were undone and the timestep was reduced.
std::string text_of(const TimestepCut& cut, const Scene& scene);
/// Warning about the range of intensities of a segmentation; empty for RangeEffect::Limits.
std::string range_warning(const std::string& name, RangeEffect effect);

}  // namespace simplexseg
