// SPDX-License-Identifier: Apache-2.0
#include "model/start_shape.h"

#include <cmath>

#include "model/similarity.h"
#include "model/template_registration.h"

namespace simplexseg {

SimplexMesh shape_at_seed(const OrganModel& model, const Eigen::Vector3d& centre_mm, double radius_mm,
                          std::span<const float> modes) {
  const PosePrior& pose = model.shape.pose;
  // Product of the distributions of the scale without the seed, and given its radius.
  const double own = 1 / std::pow(pose.log_scale.deviation, 2), given = 1 / std::pow(pose.log_radius.deviation, 2);
  const double log_scale =
      (own * pose.log_scale.mean + given * (std::log(radius_mm) - pose.log_radius.mean)) / (own + given);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(model.shape.mode_count());
  for (std::size_t m = 0; m < modes.size(); ++m) coefficients[static_cast<Eigen::Index>(m)] = modes[m];
  const Similarity placed{std::exp(log_scale), rotation_of(pose.rotation.mean), centre_mm + pose.from_seed.mean};
  return mesh_at(model.shape.mean, placed(shape_of(model.shape, coefficients)));
}

}  // namespace simplexseg
