// SPDX-License-Identifier: Apache-2.0
// Poses of several organs relative to each other.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "model/organ_model.h"

namespace simplexseg {

/// Pose of an organ: log scale, rotation vector (radians) and shift (mm) of the similarity from its mean shape.
using PoseVector = Eigen::Matrix<double, 7, 1>;

/// Normal distribution of a pose.
struct PoseDistribution {
  PoseVector mean;
  Eigen::Matrix<double, 7, 7> covariance;
};

/// Joint normal distribution of the poses of the organs of a model in one image, up to a common shift. Empty for a
/// model of one organ.
struct PoseRelations {
  Eigen::VectorXd mean;        ///< 7 entries for each organ, as in PoseVector; shifts relative to their mean
  Eigen::MatrixXd covariance;  ///< of `mean`

  int organ_count() const { return static_cast<int>(mean.size() / 7); }
};

/// Pose of an organ from the vertices of its registered template or instance, mm.
PoseVector pose_of(const ShapeModel& shape, const Eigen::Matrix3Xd& points);

/// Relations of organs in the images in which all of them were trained (TrainedCase::image_number). Few images are
/// supplemented by a prior distribution: common scale and rotation of all organs, and independent changes of each.
/// Throws Error if no image has all organs.
PoseRelations train_relations(const std::vector<OrganModel>& organs);

/// Distribution of the pose of an organ, given the poses of others in the same image: the conditional normal
/// distribution. `found`: an entry for each organ. Nothing if no other organ is found.
std::optional<PoseDistribution> expected_pose(const PoseRelations& relations, const std::vector<OrganModel>& organs,
                                              const std::vector<std::optional<PoseVector>>& found, int organ);

}  // namespace simplexseg
