// SPDX-License-Identifier: Apache-2.0
#include "model/pose_relations.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "model/similarity.h"

namespace simplexseg {
namespace {

// Deviations of the prior distribution, which counts as kPriorImages: log scale, rotation (radians) and place (sizes).
constexpr double kCommonScale = 0.06, kCommonRotation = 0.08;
constexpr double kOwnScale = 0.05, kOwnRotation = 0.1, kOwnPlace = 0.25;
constexpr double kPriorImages = 3;
constexpr double kCommonShift = 1000;  ///< deviation of the unknown common shift, mm
// Deviations of the pose of a found organ from the correct one.
constexpr double kFoundScale = 0.03, kFoundRotation = 0.05, kFoundPlace = 0.05;

/// Vector of deviations of one organ: scale, rotation, place.
PoseVector deviations(double scale, double rotation, double place) {
  PoseVector all;
  all << scale, Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(place);
  return all;
}

/// Poses of all organs in an image as one vector, with shifts relative to their mean.
Eigen::VectorXd joint_pose(const std::vector<PoseVector>& poses) {
  const auto organs = static_cast<Eigen::Index>(poses.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PoseVector& pose : poses) centre += pose.tail<3>() / static_cast<double>(organs);
  Eigen::VectorXd joint(7 * organs);
  for (Eigen::Index k = 0; k < organs; ++k) {
    joint.segment<7>(7 * k) = poses[k];
    joint.segment<3>(7 * k + 4) -= centre;
  }
  return joint;
}

/// Prior covariance of joint poses around a mean.
Eigen::MatrixXd prior_covariance(const Eigen::VectorXd& mean, const std::vector<OrganModel>& organs) {
  const Eigen::Index size = mean.size();
  Eigen::MatrixXd common = Eigen::MatrixXd::Zero(size, 4);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index k = 0; 7 * k < size; ++k) {
    const Eigen::Vector3d place = mean.segment<3>(7 * k + 4);
    common(7 * k, 0) = kCommonScale;
    common.block<3, 1>(7 * k + 4, 0) = kCommonScale * place;
    for (int a = 0; a < 3; ++a) {
      common(7 * k + 1 + a, 1 + a) = kCommonRotation;
      common.block<3, 1>(7 * k + 4, 1 + a) = kCommonRotation * Eigen::Vector3d::Unit(a).cross(place);
    }
    covariance.diagonal().segment<7>(7 * k) =
        deviations(kOwnScale, kOwnRotation, kOwnPlace * size_of(organs[k].shape)).cwiseAbs2();
  }
  return covariance + common * common.transpose();
}

}  // namespace

PoseVector pose_of(const ShapeModel& shape, const Eigen::Matrix3Xd& points) {
  Eigen::Matrix3Xd mean(3, shape.vertex_count());
  for (int v = 0; v < shape.vertex_count(); ++v) mean.col(v) = shape.mean.positions[v].cast<double>();
  const Similarity similarity = fit_similarity(mean, points);
  PoseVector pose;
  pose << std::log(similarity.scale), rotation_vector(similarity.rotation), similarity.shift_mm;
  return pose;
}

PoseRelations train_relations(const std::vector<OrganModel>& organs) {
  PoseRelations relations;
  if (organs.size() < 2) return relations;
  std::vector<Eigen::VectorXd> joint;
  for (const TrainedCase& first : organs[0].cases) {
    std::vector<PoseVector> poses;
    for (const OrganModel& organ : organs) {
      const auto same = std::ranges::find(organ.cases, first.image_number, &TrainedCase::image_number);
      if (same == organ.cases.end() || same->points.cols() == 0) break;
      poses.push_back(pose_of(organ.shape, same->points));
    }
    if (poses.size() == organs.size()) joint.push_back(joint_pose(poses));
  }
  if (joint.empty()) throw Error("the table of cases", "no image has all organs", "add an image with all of them");
  const auto images = static_cast<double>(joint.size());
  relations.mean = Eigen::VectorXd::Zero(joint[0].size());
  for (const Eigen::VectorXd& one : joint) relations.mean += one / images;
  relations.covariance = kPriorImages * prior_covariance(relations.mean, organs);
  for (const Eigen::VectorXd& one : joint)
    relations.covariance += (one - relations.mean) * (one - relations.mean).transpose();
  relations.covariance /= images + kPriorImages;
  return relations;
}

std::optional<PoseDistribution> expected_pose(const PoseRelations& relations, const std::vector<OrganModel>& organs,
                                              const std::vector<std::optional<PoseVector>>& found, int organ) {
  std::vector<int> others;
  for (int k = 0; k < relations.organ_count(); ++k)
    if (k != organ && found[k]) others.push_back(k);
  if (others.empty()) return std::nullopt;
  Eigen::MatrixXd covariance = relations.covariance;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    for (Eigen::Index j = 0; j < covariance.cols(); ++j)
      if (i % 7 >= 4 && i % 7 == j % 7) covariance(i, j) += kCommonShift * kCommonShift;
  const auto count = static_cast<Eigen::Index>(others.size());
  Eigen::MatrixXd known(7 * count, 7 * count), between(7, 7 * count);
  Eigen::VectorXd difference(7 * count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const int k = others[a];
    for (Eigen::Index b = 0; b < count; ++b)
      known.block<7, 7>(7 * a, 7 * b) = covariance.block<7, 7>(7 * k, 7 * others[b]);
    known.diagonal().segment<7>(7 * a) +=
        deviations(kFoundScale, kFoundRotation, kFoundPlace * size_of(organs[k].shape)).cwiseAbs2();
    between.block<7, 7>(0, 7 * a) = covariance.block<7, 7>(7 * organ, 7 * k);
    difference.segment<7>(7 * a) = *found[k] - relations.mean.segment<7>(7 * k);
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(known);
  PoseDistribution expected;
  expected.mean = relations.mean.segment<7>(7 * organ) + between * solver.solve(difference);
  expected.covariance =
      covariance.block<7, 7>(7 * organ, 7 * organ) - between * solver.solve(between.transpose().eval());
  expected.covariance = (0.5 * (expected.covariance + expected.covariance.transpose())).eval();
  return expected;
}

}  // namespace simplexseg
