// SPDX-License-Identifier: Apache-2.0
#include "model/model_prior.h"

#include <cmath>

#include "field/surface_prior.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr double kSharpness = 3;  ///< factor of the log odds
/// Mean squared Mahalanobis distance per sample of the profiles at which half of the trust remains. It is about 1 where
/// the model fits, and above 2.5 on other organs (docs/results/models.md).
constexpr double kSilentCost = 1.8;
constexpr double kSilentDeviations = 4;  ///< likewise, deviations of the size of the seed
constexpr double kSilentError = 0.15;    ///< likewise, surface_error_mm in sizes of the mean shape
constexpr double kSilentDepths = 0.22;   ///< likewise, surface_error_mm in depths of the organ
constexpr double kLeastTrust = 0.25;     ///< below it there is no prior

/// 1 for small values, 1/2 at `half`, 0 for large ones.
double falling(double value, double half) { return 1 / (1 + std::pow(value / half, 8)); }

/// Mean depth of the deepest place of an organ, mm.
double depth_of(const PosePrior& pose) { return std::exp(pose.log_radius.mean + pose.log_scale.mean); }

}  // namespace

double trust_in(const OrganModel& model, const ModelFit& fit) {
  const double trust = falling(fit.cost, kSilentCost) * falling(fit.size_deviations, kSilentDeviations) *
                       falling(model.surface_error_mm / size_of(model.shape), kSilentError) *
                       falling(model.surface_error_mm / depth_of(model.shape.pose), kSilentDepths);
  return trust < kLeastTrust ? 0 : trust;
}

ShapePrior shape_prior_of(const OrganModel& model, const ModelFit& fit, const VolumeGeometry& volume,
                          const RunJobs& run) {
  const double trust = trust_in(model, fit);
  ShapePrior prior =
      surface_prior(mesh_at(model.shape.mean, fit.points), model.surface_error_mm, kSharpness * trust, volume, run);
  prior.bounds_mm = {fit.points.rowwise().minCoeff(), fit.points.rowwise().maxCoeff()};
  prior.share = trust;
  return prior;
}

MakeShapePrior shape_prior_maker(std::shared_ptr<const OrganModel> model, const Volume& volume, const RunJobs& run) {
  auto fitter = std::make_shared<ModelFitter>(*model, volume, run);
  return [fitter, model = std::move(model), &volume, run](std::span<const Mark> marks) {
    const ModelFit fit = fitter->fit(marks);
    if (trust_in(*model, fit) == 0) return std::shared_ptr<const ShapePrior>();
    return std::make_shared<const ShapePrior>(shape_prior_of(*model, fit, volume.geometry(), run));
  };
}

}  // namespace simplexseg
