// SPDX-License-Identifier: Apache-2.0
#include "model/organ_model.h"

#include <cmath>

#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr double kLeastExtent = 0.8;  ///< ratio of extents of volumes with similar fields of view

}  // namespace

Eigen::Vector3d extent_mm(const VolumeGeometry& volume) {
  const Eigen::Vector3d size(volume.size[0], volume.size[1], volume.size[2]);
  return volume.direction.cwiseAbs() * volume.spacing_mm.cwiseProduct(size);
}

bool has_similar_extent(const PosePrior& pose, const VolumeGeometry& volume) {
  const Eigen::Array3d ratios = extent_mm(volume).array() / pose.extent_mm.array();
  return (ratios > kLeastExtent).all() && (ratios < 1 / kLeastExtent).all();
}

Eigen::Matrix3Xd shape_of(const ShapeModel& shape, const Eigen::VectorXd& coefficients) {
  const Eigen::VectorXf deformation = shape.modes * coefficients.cast<float>();
  return points_of(shape.mean) +
         Eigen::Map<const Eigen::Matrix3Xf>(deformation.data(), 3, shape.vertex_count()).cast<double>();
}

Eigen::VectorXd mode_variances(const ShapeModel& shape) {
  return shape.modes.cast<double>().colwise().squaredNorm().transpose();
}

double size_of(const Eigen::Matrix3Xd& centred) { return std::sqrt(centred.colwise().squaredNorm().mean()); }
double size_of(const ShapeModel& shape) { return size_of(points_of(shape.mean)); }

}  // namespace simplexseg
