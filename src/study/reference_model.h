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

/// Positions of one mesh in double, mm: a column for each vertex.
using Pose = Eigen::Matrix3Xd;
Pose pose_of(std::span<const Eigen::Vector3f> positions);
std::vector<Eigen::Vector3f> positions_of(const Pose& pose);

/// What acts on one mesh while its image targets and attraction bindings do not change. Empty spans: that force does
/// not act, whatever its weight. The spans need to live only during the construction of the model.
struct ReferenceScene {
  std::span<const std::array<int, 3>> neighbours;
  ForceParameters forces;
  std::span<const Vec4> shape;  ///< shape memory's reference (e1, e2, h_mm, S_mm2), as MeshItem has it
  /// Targets of each force that has them, which do not change: point (mm), confidence in [0, 1]. Empty: none.
  std::array<std::span<const Vec4>, kForceCount> targets;
  std::span<const Eigen::Vector3d> points_mm;  ///< attraction points of this mesh
  double voxel_mm = 1;                         ///< the unit "voxel" of parameters: smallest spacing, 1 without a volume
};

/// The model of docs/mathematics.md, section 2, in double: the acceleration sum_f k_f d_f of one mesh as a function of
/// its pose alone, and its derivative. An oracle for the engines, which compute in float: it shares no code with them,
/// only the table of parameters. Not smooth where a bound sets in, where a neighbour's normal turns past a right angle,
/// and where the neighbours are nearly collinear; the derivative is then that of the side on which the pose lies.
class ReferenceModel {
 public:
  /// Attraction points are bound to the vertices of `pose` nearest to them and to the rings around these; where
  /// neighbours are collinear the normals of `pose` count as the last good ones. Throws Error where sizes do not fit.
  ReferenceModel(const ReferenceScene& scene, const Pose& pose);

  int vertex_count() const { return static_cast<int>(neighbours_.size()); }
  const std::vector<std::array<int, 3>>& neighbours() const { return neighbours_; }
  const ForceParameters& forces() const { return forces_; }
  /// Sum of the weights of the forces that act, 1/s^2: residuals over it are in mm.
  double weight_sum() const { return weight_sum_; }

  /// sum_f k_f d_f of each vertex, mm (unit mass and time).
  Pose acceleration(const Pose& pose) const;
  /// Derivative of the acceleration at `pose` in the direction `v`: exact, by automatic differentiation.
  Pose derivative(const Pose& pose, const Pose& v) const;
  using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  /// The same as a matrix, 3V x 3V, coordinate c of vertex i in row 3i + c.
  Matrix jacobian(const Pose& pose) const { return matrix(pose, keeps_curvature_); }
  /// The same with the mean curvatures of smoothing kept as they are: a vertex then depends on its neighbours alone.
  Matrix near_jacobian(const Pose& pose) const { return matrix(pose, false); }

 private:
  template <class T>
  using Vector = Eigen::Matrix<T, 3, 1>;
  template <class T>
  struct Frame {
    Vector<T> normal;
    T curvature;  ///< h over the bounded S, 1/mm
  };
  /// What an attraction point says to a vertex: w^2 (C - P0) / sum of the vertex's w.
  struct Pull {
    double square, inverse_sum;
    int nearest;  ///< P0
    Eigen::Vector3d point_mm;
  };

  double parameter(ForceId force, int index) const { return forces_.values[static_cast<int>(force)][index]; }
  void bind(std::span<const Eigen::Vector3d> points_mm, const Pose& pose);
  template <class T>
  Frame<T> frame_of(int i, const Vector<T>& p, const Vector<T>& p1, const Vector<T>& p2, const Vector<T>& p3) const;
  template <class T>
  Vector<T> own_force(int i, const Vector<T>& p, const Vector<T>& p1, const Vector<T>& p2, const Vector<T>& p3,
                      const T& mean_curvature, bool folded) const;
  template <class T>
  std::vector<Vector<T>> evaluate(const std::vector<Vector<T>>& x) const;
  /// Rings 1 and 2 of a vertex without itself: the vertices whose curvatures are averaged.
  std::array<int, 9> around(int i) const;
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
  std::vector<double> image_share_;  ///< what attraction leaves of the image forces
  bool keeps_curvature_ = false;
  double smoothing_ = 0, shape_memory_ = 0, weight_sum_ = 0;
};

}  // namespace simplexseg
