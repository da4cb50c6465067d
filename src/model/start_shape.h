// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

#include "model/organ_model.h"

namespace simplexseg {

/// Shape of a model at a seed, mm: the mean shape deformed by the first modes, with the most probable pose for a ball
/// in the deepest place of the organ. `modes`: deviations, at most as many as the model has.
SimplexMesh shape_at_seed(const OrganModel& model, const Eigen::Vector3d& centre_mm, double radius_mm,
                          std::span<const float> modes);

}  // namespace simplexseg
