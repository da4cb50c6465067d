// SPDX-License-Identifier: Apache-2.0
// The list of forces: the one place that names them all, in the order of ForceId. To add a force: docs/add-a-force.md.
#pragma once
#include <tuple>

#include "core/forces/attraction.h"
#include "core/forces/gradient.h"
#include "core/forces/intensity_profile.h"
#include "core/forces/region.h"
#include "core/forces/shape_memory.h"
#include "core/forces/smoothing.h"

namespace simplexseg {

using Forces = std::tuple<SmoothingForce, ShapeMemoryForce, GradientForce, IntensityProfileForce, RegionForce, AttractionForce>;
static_assert(std::tuple_size_v<Forces> == kForceCount);

}  // namespace simplexseg
