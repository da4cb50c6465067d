// SPDX-License-Identifier: Apache-2.0
// The list of forces: the one place that names them all, in the order of ForceId. To add a force: docs/add-a-force.md.
#pragma once
#include <tuple>

#include "forces/attraction.h"
#include "forces/gradient.h"
#include "forces/intensity_profile.h"
#include "forces/region.h"
#include "forces/shape_memory.h"
#include "forces/smoothing.h"

namespace simplexseg {

using Forces =
    std::tuple<SmoothingForce, ShapeMemoryForce, GradientForce, IntensityProfileForce, RegionForce, AttractionForce>;
static_assert(std::tuple_size_v<Forces> == kForceCount);

}  // namespace simplexseg
