// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <span>
#include <vector>

#include "core/vec3.h"
#include "forces/parameters.h"

namespace simplexseg {

/// Positions of one mesh in double, mm: a column per vertex.
using Pose = Eigen::Matrix3Xd;
Pose pose_of(std::span<const Eigen::Vector3f> positions);
std::vector<Eigen::Vector3f> positions_of(const Pose& pose);

/// Forces on one mesh with fixed image targets and attraction bindings. A force that needs a shape reference, targets
/// or points does not act if its span is empty, regardless of its weight. The spans must remain valid only during the
/// construction of the model.
struct ReferenceScene {
  std::span<const std::array<int, 3>> neighbours;
  ForceParameters forces;
  std::span<const Vec4> shape;  ///< reference of shape memory (e1, e2, h_mm, S_mm2), as in MeshItem
  /// Fixed targets of each force with targets, per vertex: point (mm), confidence in [0, 1]. Empty: none.
  std::array<std::span<const Vec4>, kForceCount> targets;
  std::span<const Eigen::Vector3d> points_mm;  ///< attraction points of this mesh
  double voxel_mm = 1;                         ///< unit "voxel" of parameters, mm: smallest spacing, 1 without a volume
};

/// Reference implementation of the model of docs/mathematics.md, section 2, in double: the acceleration sum_f k_f d_f
/// of one mesh as a function of its pose, and its derivative. The engines, which compute in float, are tested against
/// it; it shares only the table of parameters with them. The model is not smooth, and its derivative one-sided, where a
/// bound becomes active, where a neighbour's normal passes a right angle, and where neighbours are nearly collinear.
class ReferenceModel {
 public:
  /// Binds attraction points to the nearest vertices of `pose` and the rings around them. Vertices with collinear
  /// neighbours use the normals of `pose` as their last valid normals. Throws Error if sizes do not match or a force of
  /// nonzero weight is not implemented.
  ReferenceModel(const ReferenceScene& scene, const Pose& pose);

  int vertex_count() const { return static_cast<int>(neighbours_.size()); }
  const std::vector<std::array<int, 3>>& neighbours() const { return neighbours_; }
  const ForceParameters& forces() const { return forces_; }
  /// Sum of the weights of the active forces, 1/s^2; a residual divided by it is in mm.
  double weight_sum() const { return weight_sum_; }

  /// Acceleration sum_f k_f d_f of each vertex for unit mass, mm/s^2.
  Pose acceleration(const Pose& pose) const;
  /// Derivative of the acceleration at `pose` in the direction `v`: exact, by automatic differentiation.
  Pose derivative(const Pose& pose, const Pose& v) const;
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  /// Derivative as a 3V x 3V matrix; coordinate c of vertex i is row 3i + c.
  Matrix jacobian(const Pose& pose) const { return matrix(pose, preserves_curvature_); }
  /// Derivative with constant mean curvatures in smoothing; the smoothing force on a vertex then depends only on the
  /// vertex and its neighbours.
  Matrix near_jacobian(const Pose& pose) const { return matrix(pose, false); }

 private:
  template <class T>
  using Vector = Eigen::Matrix<T, 3, 1>;
  template <class T>
  struct Frame {
    Vector<T> normal;
    T curvature;  ///< elevation h divided by S, which is bounded from below, 1/mm
  };
  /// Force of an attraction point C on a vertex: w^2 (C - P0) / sum of the w of the vertex; P0: vertex nearest to C.
  struct Pull {
    double square, inverse_sum;
    int nearest;  ///< index of P0
    Eigen::Vector3d point_mm;
  };

  double parameter(ForceId force, int index) const { return forces_.values[static_cast<int>(force)][index]; }
  void bind(std::span<const Eigen::Vector3d> points_mm, const Pose& pose);
  template <class T>
  Frame<T> frame_of(int i, const Vector<T>& p, const Vector<T>& p1, const Vector<T>& p2, const Vector<T>& p3) const;
  template <class T>
  Vector<T> local_force(int i, const Vector<T>& p, const Vector<T>& p1, const Vector<T>& p2, const Vector<T>& p3,
                        const T& mean_curvature, bool folded) const;
  template <class T>
  std::vector<Vector<T>> evaluate(const std::vector<Vector<T>>& x) const;
  /// Vertices of rings 1 and 2 around a vertex, whose curvatures are averaged; without the vertex itself.
  std::array<int, 9> two_rings(int i) const;
  Matrix matrix(const Pose& pose, bool moving_curvature) const;

  std::vector<std::array<int, 3>> neighbours_;
  ForceParameters forces_;
  std::vector<Vec4> shape_;
  struct ImageForce {
    double weight, pull_mm;
    std::vector<Vec4> targets;
  };
  std::vector<ImageForce> image_;
  std::vector<Eigen::Vector3d> last_normals_;
  std::vector<int> first_pull_;  ///< V + 1 offsets into pulls_
  std::vector<Pull> pulls_;
  std::vector<double> image_share_;  ///< factor of the image forces of each vertex, below 1 near attraction points
  bool preserves_curvature_ = false;
  double smoothing_ = 0, shape_memory_ = 0, weight_sum_ = 0;
};

}  // namespace simplexseg
