// SPDX-License-Identifier: Apache-2.0
#include "model/template_registration.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <limits>

#include "mesh/mesh_geometry.h"
#include "model/similarity.h"

namespace simplexseg {
namespace {

constexpr int kRigidIterations = 40, kIterationsPerStiffness = 6;
constexpr std::array kStiffness{30.0, 10.0, 5.0, 3.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1};
constexpr double kLeastCosine = 0.3;          ///< of compatible normals
constexpr double kIncompatibleWeight = 0.05;  ///< of a vertex without a compatible point nearby
constexpr double kReverseWeight = 0.5;        ///< of the points whose nearest vertex it is

/// Points in three arrays, for searches that the compiler vectorises.
struct PointList {
  std::array<std::vector<float>, 3> at;
  explicit PointList(const Eigen::Matrix3Xd& points) {
    for (int a = 0; a < 3; ++a) {
      at[a].resize(points.cols());
      for (Eigen::Index p = 0; p < points.cols(); ++p) at[a][p] = static_cast<float>(points(a, p));
    }
  }
  int count() const { return static_cast<int>(at[0].size()); }
  /// Squared distances of all points to a place.
  void squares(const Eigen::Vector3f& to, std::vector<float>& square) const {
    const int n = count();
    square.resize(n);
    const float *const x = at[0].data(), *const y = at[1].data(), *const z = at[2].data();
#pragma GCC ivdep
    for (int p = 0; p < n; ++p) {
      const float dx = x[p] - to[0], dy = y[p] - to[1], dz = z[p] - to[2];
      square[p] = dx * dx + dy * dy + dz * dz;
    }
  }
};

/// Target of a vertex, and its weight.
struct Correspondence {
  Eigen::Vector3d sum{0, 0, 0};  ///< of weighted targets
  double weight = 0;
};

class Registration {
 public:
  Registration(const SimplexMesh& mesh, const SimplexMesh& surface)
      : neighbours_(mesh.neighbours),
        rest_(points_of(mesh)),
        target_(points_of(surface)),
        target_normals_(normals_of(surface.neighbours, target_)),
        target_list_(target_),
        edge_mm_(mean_edge_mm(mesh.positions, mesh.neighbours)) {}

  Eigen::Matrix3Xd run() {
    Eigen::Matrix3Xd x = rest_.colwise() + (target_.rowwise().mean() - rest_.rowwise().mean());
    std::vector<float> square;
    for (int k = 0; k < kRigidIterations; ++k) {
      Eigen::Matrix3Xd nearest(3, x.cols());
      for (Eigen::Index v = 0; v < x.cols(); ++v) {
        target_list_.squares(x.col(v).cast<float>(), square);
        nearest.col(v) = target_.col(std::min_element(square.begin(), square.end()) - square.begin());
      }
      x = fit_similarity(rest_, nearest)(rest_);
    }
    for (const double stiffness : kStiffness)
      for (int k = 0; k < kIterationsPerStiffness; ++k) x = deform(x, stiffness);
    return x;
  }

 private:
  std::vector<Correspondence> correspondences(const Eigen::Matrix3Xd& x) const {
    const Eigen::Matrix3Xd normals = normals_of(neighbours_, x);
    std::vector<Correspondence> all(x.cols());
    std::vector<float> square;
    for (Eigen::Index v = 0; v < x.cols(); ++v) {
      target_list_.squares(x.col(v).cast<float>(), square);
      int nearest = 0, compatible = -1;
      for (int p = 0; p < target_list_.count(); ++p) {
        if (square[p] < square[nearest]) nearest = p;
        if ((compatible < 0 || square[p] < square[compatible]) &&
            target_normals_.col(p).dot(normals.col(v)) > kLeastCosine)
          compatible = p;
      }
      // A compatible point that is much farther than the nearest one belongs to another part of the surface.
      const double limit = 3 * std::sqrt(square[nearest]) + edge_mm_;
      const bool found = compatible >= 0 && square[compatible] < limit * limit;
      const double weight = found ? 1 : kIncompatibleWeight;
      const int to = found ? compatible : nearest;
      // The point of the tangent plane, so that vertices do not gather at the points of the surface.
      const Eigen::Vector3d plane = target_normals_.col(to), q = target_.col(to);
      all[v] = {weight * (x.col(v) + plane.dot(q - x.col(v)) * plane), weight};
    }
    const PointList vertices(x);
    std::vector<Correspondence> reverse(x.cols());
    for (Eigen::Index p = 0; p < target_.cols(); ++p) {
      vertices.squares(target_.col(p).cast<float>(), square);
      Correspondence& at = reverse[std::min_element(square.begin(), square.end()) - square.begin()];
      at.sum += target_.col(p), at.weight += 1;
    }
    for (Eigen::Index v = 0; v < x.cols(); ++v) {
      if (reverse[v].weight == 0) continue;
      all[v].sum += kReverseWeight / reverse[v].weight * reverse[v].sum;
      all[v].weight += kReverseWeight;
    }
    return all;
  }

  Eigen::Matrix3Xd deform(const Eigen::Matrix3Xd& x, double stiffness) {
    const Eigen::Matrix3Xd y = fit_similarity(rest_, x)(rest_);
    const std::vector<Correspondence> to = correspondences(x);
    const auto n = static_cast<int>(x.cols());
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(4 * std::size_t(n));
    Eigen::MatrixX3d right(n, 3);
    for (int v = 0; v < n; ++v) {
      entries.emplace_back(v, v, to[v].weight + 3 * stiffness);
      for (const int u : neighbours_[v]) entries.emplace_back(v, u, -stiffness);
      right.row(v) = (to[v].sum - to[v].weight * y.col(v)).transpose();
    }
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    if (!analysed_) solver_.analyzePattern(matrix), analysed_ = true;
    solver_.factorize(matrix);
    return y + solver_.solve(right).transpose();
  }

  const std::vector<std::array<int, 3>>& neighbours_;
  const Eigen::Matrix3Xd rest_, target_, target_normals_;
  const PointList target_list_;
  const double edge_mm_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  bool analysed_ = false;
};

}  // namespace

Eigen::Matrix3Xd points_of(const SimplexMesh& mesh) {
  Eigen::Matrix3Xd points(3, mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) points.col(v) = position_of(mesh, v);
  return points;
}

SimplexMesh mesh_at(const SimplexMesh& mesh, const Eigen::Matrix3Xd& points) {
  SimplexMesh moved = mesh;
  for (int v = 0; v < mesh.vertex_count(); ++v) moved.positions[v] = points.col(v).cast<float>();
  return moved;
}

Eigen::Matrix3Xd normals_of(const std::vector<std::array<int, 3>>& neighbours, const Eigen::Matrix3Xd& points) {
  Eigen::Matrix3Xd normals(3, points.cols());
  for (Eigen::Index v = 0; v < points.cols(); ++v) {
    const auto [a, b, c] = neighbours[v];
    const Eigen::Vector3d p = points.col(a), q = points.col(b) - p, r = points.col(c) - p;
    const Eigen::Vector3d n = q.cross(r);
    const double length = n.norm();
    normals.col(v) = length > 0 ? Eigen::Vector3d(n / length) : Eigen::Vector3d(0, 0, 1);
  }
  return normals;
}

Eigen::Matrix3Xd register_template(const SimplexMesh& mesh, const SimplexMesh& surface) {
  return Registration(mesh, surface).run();
}

}  // namespace simplexseg
