// SPDX-License-Identifier: Apache-2.0
#include "mesh/remesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/expect.h"

namespace simplexseg {
namespace {

constexpr int kPasses = 6;
// Relative to the target length. An edge beyond these bounds gets closer to the target: a split halves it, and a
// contraction lengthens its neighbours to about 3/2 of their length (Botsch and Kobbelt 2004).
constexpr double kMaxLength = 4.0 / 3, kMinLength = 4.0 / 5;
constexpr std::size_t kMinValence = 4;
constexpr double kMinCosine = 0.3;  // smallest cosine between the normals of a triangle before and after an operation

class Remesher {
 public:
  Remesher(const TriangleMesh& surface, double edge_mm, const SurfaceProjection& project)
      : triangles_(surface.triangles), edge_(edge_mm), project_(project) {
    for (const Eigen::Vector3f& p : surface.positions) positions_.push_back(p.cast<double>());
    around_.resize(positions_.size());
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
      for (const int v : triangles_[t]) around_[v].push_back(t);
  }

  TriangleMesh run() && {
    for (int pass = 0; pass < kPasses; ++pass) {
      for_each_edge([&](int a, int b) { split_if_long(a, b); });
      for_each_edge([&](int a, int b) { contract_if_short(a, b); });
      for_each_edge([&](int a, int b) { flip_if_more_regular(a, b); });
      relax_tangentially();
    }
    return compact();
  }

 private:
  using Triangle = std::array<int, 3>;

  bool exists(int t) const { return triangles_[t][0] >= 0; }
  double length(int a, int b) const { return (positions_[a] - positions_[b]).norm(); }
  /// Normal vector whose length is twice the area, mm^2.
  Eigen::Vector3d normal(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) const {
    return (b - a).cross(c - a);
  }
  Eigen::Vector3d normal(const Triangle& t) const {
    return normal(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  }
  static bool is_flipped(const Eigen::Vector3d& before, const Eigen::Vector3d& after) {
    return !(after.dot(before) > kMinCosine * after.norm() * before.norm());
  }

  /// Calls work(a, b) for each edge that still exists when it is reached. Skips the triangles that `work` adds.
  template <class Work>
  void for_each_edge(Work&& work) {
    const int count = static_cast<int>(triangles_.size());
    for (int t = 0; t < count; ++t)
      for (int e = 0; e < 3 && exists(t); ++e) {
        const int a = triangles_[t][e], b = triangles_[t][(e + 1) % 3];
        if (a < b) work(a, b);  // the adjacent triangle has the edge reversed
      }
  }

  /// Triangle on one side of an edge, and the corner of that triangle opposite to the edge.
  struct Wing {
    int triangle = -1, corner = -1;
  };
  Wing wing(int a, int b) const {  // of the triangle that contains the half-edge from a to b
    for (const int t : around_[a])
      for (int e = 0; e < 3; ++e)
        if (triangles_[t][e] == a && triangles_[t][(e + 1) % 3] == b) return {t, triangles_[t][(e + 2) % 3]};
    return {};
  }
  bool are_neighbours(int a, int b) const {
    return std::any_of(around_[a].begin(), around_[a].end(), [&](int t) {
      const Triangle& corners = triangles_[t];
      return corners[0] == b || corners[1] == b || corners[2] == b;
    });
  }
  int common_neighbours(int a, int b) const {
    int common = 0;
    for (const int t : around_[a])
      for (int e = 0; e < 3; ++e)  // each neighbour of `a` follows `a` in exactly one triangle
        if (triangles_[t][e] == a) {
          const int n = triangles_[t][(e + 1) % 3];
          common += n != b && are_neighbours(n, b);
        }
    return common;
  }
  void replace_corner(int t, int from, int to) {
    std::replace(triangles_[t].begin(), triangles_[t].end(), from, to);
    std::erase(around_[from], t);
    around_[to].push_back(t);
  }
  void remove(int t) {
    for (const int v : triangles_[t]) std::erase(around_[v], t);
    triangles_[t] = {-1, -1, -1};
  }
  void add(const Triangle& t) {
    for (const int v : t) around_[v].push_back(static_cast<int>(triangles_.size()));
    triangles_.push_back(t);
  }

  void split_if_long(int a, int b) {
    if (length(a, b) <= kMaxLength * edge_) return;
    const Wing left = wing(a, b), right = wing(b, a);
    const int middle = static_cast<int>(positions_.size());
    positions_.push_back(0.5 * (positions_[a] + positions_[b]));
    around_.emplace_back();
    replace_corner(left.triangle, b, middle);
    replace_corner(right.triangle, b, middle);
    add({middle, b, left.corner});
    add({b, middle, right.corner});
  }

  void contract_if_short(int a, int b) {
    if (length(a, b) >= kMinLength * edge_) return;
    const Wing left = wing(a, b), right = wing(b, a);
    if (around_[left.corner].size() <= kMinValence || around_[right.corner].size() <= kMinValence) return;
    if (around_[a].size() + around_[b].size() - 4 < kMinValence) return;
    if (common_neighbours(a, b) != 2) return;
    const Eigen::Vector3d middle = 0.5 * (positions_[a] + positions_[b]);
    for (const int end : {a, b})
      for (const int t : around_[end]) {
        if (t == left.triangle || t == right.triangle) continue;
        std::array<Eigen::Vector3d, 3> corner;
        for (int e = 0; e < 3; ++e) {
          const int v = triangles_[t][e];
          corner[e] = v == end ? middle : positions_[v];
          if (v != end && (positions_[v] - middle).norm() > kMaxLength * edge_) return;
        }
        if (is_flipped(normal(triangles_[t]), normal(corner[0], corner[1], corner[2]))) return;
      }
    remove(left.triangle);
    remove(right.triangle);
    positions_[a] = middle;
    const std::vector<int> moved = around_[b];
    for (const int t : moved) replace_corner(t, b, a);
  }

  void flip_if_more_regular(int a, int b) {
    const Wing left = wing(a, b), right = wing(b, a);
    const int c = left.corner, d = right.corner;
    const auto irregularity = [&](int v, int change) {
      return std::abs(static_cast<int>(around_[v].size()) + change - 6);
    };
    const auto squares = [](auto... x) { return (... + (x * x)); };
    if (around_[a].size() <= kMinValence || around_[b].size() <= kMinValence || are_neighbours(c, d)) return;
    if (squares(irregularity(a, -1), irregularity(b, -1), irregularity(c, 1), irregularity(d, 1)) >=
        squares(irregularity(a, 0), irregularity(b, 0), irregularity(c, 0), irregularity(d, 0)))
      return;
    const Triangle first{a, d, c}, second{b, c, d};
    for (const Triangle& now : {first, second})
      for (const int before : {left.triangle, right.triangle})
        if (is_flipped(normal(triangles_[before]), normal(now))) return;
    remove(left.triangle);
    remove(right.triangle);
    add(first);
    add(second);
  }

  void relax_tangentially() {
    for (std::size_t v = 0; v < positions_.size(); ++v) {
      if (around_[v].empty()) continue;
      Eigen::Vector3d middle = Eigen::Vector3d::Zero(), outward = Eigen::Vector3d::Zero();
      for (const int t : around_[v]) {
        for (const int n : triangles_[t]) middle += n == static_cast<int>(v) ? Eigen::Vector3d::Zero() : positions_[n];
        outward += normal(triangles_[t]);
      }
      outward.normalize();
      if (!outward.allFinite()) continue;
      Eigen::Vector3d move = middle / (2.0 * static_cast<double>(around_[v].size())) - positions_[v];
      move -= move.dot(outward) * outward;
      const Eigen::Vector3d before = positions_[v];
      std::vector<Eigen::Vector3d> normals;
      for (const int t : around_[v]) normals.push_back(normal(triangles_[t]));
      positions_[v] = project_(before + 0.5 * move);
      for (std::size_t k = 0; k < normals.size(); ++k)
        if (is_flipped(normals[k], normal(triangles_[around_[v][k]]))) {
          positions_[v] = before;
          break;
        }
    }
  }

  TriangleMesh compact() const {
    TriangleMesh surface;
    std::vector<int> index(positions_.size(), -1);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!exists(static_cast<int>(t))) continue;
      Triangle& corners = surface.triangles.emplace_back();
      for (int e = 0; e < 3; ++e) {
        int& v = index[triangles_[t][e]];
        if (v < 0) {
          v = static_cast<int>(surface.positions.size());
          surface.positions.push_back(positions_[triangles_[t][e]].cast<float>());
        }
        corners[e] = v;
      }
    }
    return surface;
  }

  std::vector<Eigen::Vector3d> positions_;
  std::vector<Triangle> triangles_;       ///< corners of each triangle; -1 for a removed triangle
  std::vector<std::vector<int>> around_;  ///< triangles around each vertex
  const double edge_;
  const SurfaceProjection& project_;
};

}  // namespace

TriangleMesh remesh(const TriangleMesh& surface, double edge_mm, const SurfaceProjection& project) {
  SIMPLEXSEG_EXPECT(edge_mm > 0 && project);
  return Remesher(surface, edge_mm, project).run();
}

SimplexMesh remeshed_dual_of(const TriangleMesh& surface, double edge_mm, const SurfaceProjection& project) {
  SimplexMesh mesh = dual_of(remesh(surface, edge_mm, project));
  for (Eigen::Vector3f& p : mesh.positions) p = project(p.cast<double>()).cast<float>();
  return mesh;
}

double equilateral_edge_mm(const TriangleMesh& surface, double triangles) {
  return std::sqrt(area_mm2(surface) / triangles * 4 / std::numbers::sqrt3);
}

double area_mm2(const TriangleMesh& surface) {
  double area = 0;
  for (const auto& t : surface.triangles) {
    const auto at = [&](int k) { return surface.positions[t[k]].cast<double>(); };
    area += 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
  }
  return area;
}

}  // namespace simplexseg
