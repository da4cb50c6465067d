// SPDX-License-Identifier: Apache-2.0
#include "model/similarity.h"

#include <Eigen/SVD>

namespace simplexseg {

Similarity fit_similarity(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Vector3d from_centre = from.rowwise().mean(), to_centre = to.rowwise().mean();
  const Eigen::Matrix3Xd p = from.colwise() - from_centre, q = to.colwise() - to_centre;
  const Eigen::Matrix3d products = q * p.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, 1);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs[2] = -1;
  Similarity result;
  result.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  result.scale = svd.singularValues().dot(signs) / p.squaredNorm();
  result.shift_mm = to_centre - result.scale * (result.rotation * from_centre);
  return result;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

}  // namespace simplexseg
