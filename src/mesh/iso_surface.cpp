// SPDX-License-Identifier: Apache-2.0
#include "mesh/iso_surface.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "core/expect.h"

namespace simplexseg {
namespace {

/// Tetrahedra of a cube around its diagonal from corner 0 to corner 7, all of the same orientation. Corner indices have
/// the bits x (lowest), y and z.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
constexpr double kMinShare = 1.0 / 6;  // smallest distance of a vertex from the ends of its grid edge, edge lengths

class Marcher {
 public:
  Marcher(std::span<const float> values, const std::array<int, 3>& size, float level, const Eigen::Affine3d& mm)
      : values_(values), size_(size), level_(level), mm_(mm) {}

  TriangleMesh march() && {
    // Includes one layer of cubes on each side of the grid, whose outer corners count as outside the surface.
    for (int k = -1; k < size_[2]; ++k)
      for (int j = -1; j < size_[1]; ++j)
        for (int i = -1; i < size_[0]; ++i) cube({i, j, k});
    return std::move(surface_);
  }

 private:
  using Point = std::array<int, 3>;

  float value(const Point& p) const {
    for (int a = 0; a < 3; ++a)
      if (p[a] < 0 || p[a] >= size_[a]) return std::min(0.0f, level_ - 1);
    return values_[(static_cast<std::size_t>(p[2]) * size_[1] + p[1]) * size_[0] + p[0]];
  }
  std::uint64_t point_index(const Point& p) const {
    return (static_cast<std::uint64_t>(p[2] + 1) * (size_[1] + 2) + (p[1] + 1)) * (size_[0] + 2) + (p[0] + 1);
  }

  void cube(const Point& at) {
    Point corner[8];
    float v[8];
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      corner[c] = {at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2)};
      v[c] = value(corner[c]);
      inside += v[c] > level_;
    }
    if (inside == 0 || inside == 8) return;
    for (const auto& tetrahedron : kTetrahedra) {
      int in[4], out[4], ins = 0, outs = 0;
      for (const int c : tetrahedron) (v[c] > level_ ? in[ins++] : out[outs++]) = c;
      const auto cut = [&](int a, int b) { return vertex(corner[in[a]], v[in[a]], corner[out[b]], v[out[b]]); };
      if (ins == 1) triangle(cut(0, 0), cut(0, 1), cut(0, 2), corner[in[0]]);
      if (ins == 3) triangle(cut(0, 0), cut(1, 0), cut(2, 0), corner[in[0]]);
      if (ins == 2) {
        const int a = cut(0, 0), b = cut(0, 1), c = cut(1, 1), d = cut(1, 0);
        triangle(a, b, c, corner[in[0]]);
        triangle(a, c, d, corner[in[0]]);
      }
    }
  }

  /// Index of the vertex on the edge between a corner inside and a corner outside; creates the vertex if necessary.
  int vertex(const Point& in, float v_in, const Point& out, float v_out) {
    // The key of an edge is independent of the order of its ends: the lower end and one of seven directions.
    const Point low{std::min(in[0], out[0]), std::min(in[1], out[1]), std::min(in[2], out[2])};
    const int direction = (in[0] != out[0]) + 2 * (in[1] != out[1]) + 4 * (in[2] != out[2]);
    const auto [found, is_new] =
        vertices_.try_emplace(8 * point_index(low) + direction, static_cast<int>(surface_.positions.size()));
    if (is_new) {
      const double share = std::clamp(static_cast<double>(v_in - level_) / (v_in - v_out), kMinShare, 1 - kMinShare);
      const Eigen::Vector3d a(in[0], in[1], in[2]), b(out[0], out[1], out[2]);
      surface_.positions.push_back((mm_ * (a + share * (b - a))).cast<float>());
    }
    return found->second;
  }

  /// Adds a triangle, counter-clockwise seen from outside, so that its normal points away from the corner `inside`.
  void triangle(int a, int b, int c, const Point& inside) {
    const auto at = [&](int v) { return surface_.positions[v].cast<double>(); };
    const Eigen::Vector3d normal = (at(b) - at(a)).cross(at(c) - at(a));
    if (normal.dot(mm_ * Eigen::Vector3d(inside[0], inside[1], inside[2]) - at(a)) > 0) std::swap(b, c);
    surface_.triangles.push_back({a, b, c});
  }

  std::span<const float> values_;
  const std::array<int, 3> size_;
  const float level_;
  const Eigen::Affine3d mm_;
  std::unordered_map<std::uint64_t, int> vertices_;
  TriangleMesh surface_;
};

}  // namespace

TriangleMesh iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                         const Eigen::Affine3d& mm_from_index) {
  SIMPLEXSEG_EXPECT(values.size() == static_cast<std::size_t>(size[0]) * size[1] * size[2]);
  return Marcher(values, size, level, mm_from_index).march();
}

Eigen::Vector3d project_onto_iso_surface(std::span<const float> values, const std::array<int, 3>& size, float level,
                                         const Eigen::Affine3d& mm_from_index, const Eigen::Vector3d& mm) {
  SIMPLEXSEG_EXPECT(values.size() == static_cast<std::size_t>(size[0]) * size[1] * size[2]);
  const Eigen::Affine3d index_from_mm = mm_from_index.inverse();
  Eigen::Vector3d at = mm;
  for (int step = 0; step < 2; ++step) {
    const Eigen::Vector3d index = index_from_mm * at;
    std::array<int, 3> first;
    std::array<double, 3> share;
    for (int a = 0; a < 3; ++a) {
      if (!(index[a] >= 0 && index[a] <= size[a] - 1)) return at;
      first[a] = std::clamp(static_cast<int>(index[a]), 0, std::max(0, size[a] - 2));
      share[a] = index[a] - first[a];
    }
    double value = 0;
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();  // derivatives along the grid axes
    for (int c = 0; c < 8; ++c) {
      std::array<double, 3> weight, sign;
      std::array<int, 3> p;
      for (int a = 0; a < 3; ++a) {
        const bool upper = (c >> a & 1) != 0;
        p[a] = std::min(first[a] + upper, size[a] - 1);
        weight[a] = upper ? share[a] : 1 - share[a];
        sign[a] = upper ? 1 : -1;
      }
      const double v = values[(static_cast<std::size_t>(p[2]) * size[1] + p[1]) * size[0] + p[0]];
      value += weight[0] * weight[1] * weight[2] * v;
      slope += v * Eigen::Vector3d(sign[0] * weight[1] * weight[2], weight[0] * sign[1] * weight[2],
                                   weight[0] * weight[1] * sign[2]);
    }
    const Eigen::Vector3d gradient = index_from_mm.linear().transpose() * slope;  // per mm
    if (!(gradient.squaredNorm() > 0)) return at;
    Eigen::Vector3d move = (level - value) / gradient.squaredNorm() * gradient;
    const double cells = (index_from_mm.linear() * move).cwiseAbs().maxCoeff();
    if (!(cells < 1e6)) return at;
    if (cells > 0.5) move *= 0.5 / cells;
    at += move;
  }
  return at;
}

}  // namespace simplexseg
