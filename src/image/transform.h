// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

/// Displacements on a grid of voxels, mm in the patient frame (LPS). Copies share the vectors.
class DisplacementField {
 public:
  DisplacementField() = default;
  /// `vectors`: one for each voxel of the grid, i fastest. Throws Error if their number is another one or the grid is
  /// not valid.
  DisplacementField(VolumeGeometry grid, std::vector<Eigen::Vector3f> vectors);

  const VolumeGeometry& grid() const { return grid_; }
  const std::vector<Eigen::Vector3f>& vectors() const { return *vectors_; }
  /// Displacement at a point (mm): trilinear interpolation, and 0 outside the outer faces of the grid, as in
  /// itk::DisplacementFieldTransform.
  Eigen::Vector3d at(const Eigen::Vector3d& world_mm) const;

 private:
  VolumeGeometry grid_;
  Eigen::Affine3d index_from_world_ = Eigen::Affine3d::Identity();
  std::shared_ptr<const std::vector<Eigen::Vector3f>> vectors_;
};

/// Spatial transform from points of a fixed image to points of a moving image, mm in the patient frame (LPS), as in
/// ITK: a list of affine maps and displacement fields, in the order in which they act on a point. Without steps it is
/// the identity.
class Transform {
 public:
  using Step = std::variant<Eigen::Affine3d, DisplacementField>;

  Transform() = default;
  explicit Transform(const Eigen::Affine3d& affine) { append(affine); }

  const std::vector<Step>& steps() const { return steps_; }
  /// Adds a map that acts after those present. Consecutive affine maps become one.
  void append(const Eigen::Affine3d& affine);
  void append(DisplacementField field) { steps_.emplace_back(std::move(field)); }
  void append(const Transform& other);

  Eigen::Vector3d operator()(Eigen::Vector3d world_mm) const;
  /// Affine map that equals this transform; nullopt if it has a displacement field.
  std::optional<Eigen::Affine3d> affine() const;
  /// Point that is mapped onto `world_mm`, found by fixed-point iteration where there are fields (at most `iterations`
  /// steps, until a step is below `tolerance_mm`). nullopt if an affine map is singular or the iteration does not reach
  /// the tolerance, as where a field folds.
  std::optional<Eigen::Vector3d> inverse(const Eigen::Vector3d& world_mm, double tolerance_mm = 1e-4,
                                         int iterations = 200) const;

 private:
  std::vector<Step> steps_;
};

/// Rotation R that maximises the trace of R^T `matrix`: its nearest rotation, and the solution of Procrustes' problem
/// for a covariance matrix.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

/// Rigid map that minimises the sum of squared distances from the mapped `fixed` to the `moving` landmarks, mm, in
/// closed form (Horn 1987; by singular values, Umeyama 1991). Throws Error for fewer than three landmarks, different
/// numbers, or landmarks on a line.
Eigen::Affine3d rigid_from_landmarks(const std::vector<Eigen::Vector3d>& fixed,
                                     const std::vector<Eigen::Vector3d>& moving);

/// Determinant of the Jacobian matrix of a transform over a grid.
struct JacobianRange {
  double min = 1, max = 1;
  double folded_share = 0;  ///< share of voxels with a determinant <= 0
};
/// Range of the determinant of the Jacobian at the voxels of a grid, by central differences over one voxel. Voxels at
/// the border are omitted, because fields end there.
JacobianRange jacobian_range(const Transform& transform, const VolumeGeometry& grid);

/// Moving image on the grid of the fixed image: each voxel has the value of `moving` at its transformed centre,
/// interpolated trilinearly. Without `outside`, the voxels have the type of `moving`, are rounded for integers, and are
/// 0 outside it; with it they are 32-bit floating-point numbers, and `outside` there. `threads`: number of threads, 0
/// for all cores. Throws Error if there is too little memory.
Volume resample_through(const Volume& moving, const VolumeGeometry& grid, const Transform& transform, int threads = 0,
                        std::optional<float> outside = std::nullopt);

}  // namespace simplexseg
