// SPDX-License-Identifier: Apache-2.0
// Prior of the object from a surface whose error is known.
#pragma once
#include <memory>

#include "field/shape_prior.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Log odds that a place belongs to the object inside a surface, whose error is normal with this deviation; multiplied
/// by `strength`. Probabilities are bounded by 1% and 99%. `volume`: grid of the image, whose cells limit the
/// resolution.
ShapePrior surface_prior(const SimplexMesh& surface, double error_mm, double strength, const VolumeGeometry& volume,
                         const RunJobs& run);

/// Factory of the prior of a surface of an earlier study, the same for all marks; computed at the first call.
MakeShapePrior surface_prior_maker(std::shared_ptr<const SimplexMesh> surface, double error_mm,
                                   const VolumeGeometry& volume, const RunJobs& run);

}  // namespace simplexseg
