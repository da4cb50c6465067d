// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "field/shape_prior.h"
#include "model/model_fit.h"

namespace simplexseg {

/// Trust in an instance of a model, 0 to 1: smaller where the profiles fit worse than on unseen cases of the organ, or
/// where the seed is too large or too small for it, or where the model has large errors on unseen cases itself.
double trust_in(const OrganModel& model, const ModelFit& fit);

/// Log odds that a place belongs to the object, from an instance of a model: probability that it lies inside the
/// surface if that has a normal error with deviation OrganModel::surface_error_mm; multiplied by the trust. `volume`:
/// grid of the image.
ShapePrior shape_prior_of(const OrganModel& model, const ModelFit& fit, const VolumeGeometry& volume,
                          const RunJobs& run);

/// Factory of shape priors for an image, which must outlive it.
MakeShapePrior shape_prior_maker(std::shared_ptr<const OrganModel> model, const Volume& volume, const RunJobs& run);

}  // namespace simplexseg
