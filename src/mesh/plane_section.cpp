// SPDX-License-Identifier: Apache-2.0
#include "mesh/plane_section.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

constexpr double kLeastArea = 1e-6;  // of a polygon, in pixels: doubled_area()

/// Where a triangle meets a plane: from the edge that goes down through it to the edge that comes up, so that the solid
/// lies to the left. Edges are named by their ends, the smaller one first.
struct Cut {
  std::uint64_t from, to;
};

std::uint64_t edge_name(int a, int b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
}

/// The cuts of one plane, each edge of which begins one, put together.
std::vector<Polygon> chain(const std::vector<Cut>& cuts, const std::vector<Eigen::Vector3d>& at, double height) {
  std::unordered_map<std::uint64_t, std::uint64_t> next;
  for (const Cut& cut : cuts) next[cut.from] = cut.to;
  std::vector<Polygon> polygons;
  for (const Cut& cut : cuts) {
    Polygon polygon;
    for (auto cursor = next.extract(cut.from); cursor; cursor = next.extract(cursor.mapped())) {
      const Eigen::Vector3d &a = at[cursor.key() >> 32], &b = at[cursor.key() & 0xffffffffu];
      polygon.push_back((a + (height - a[2]) / (b[2] - a[2]) * (b - a)).head<2>());
    }
    if (polygon.size() > 2 && std::abs(doubled_area(polygon)) > kLeastArea) polygons.push_back(std::move(polygon));
  }
  return polygons;
}

bool contains(const Polygon& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t n = 0, before = polygon.size() - 1; n < polygon.size(); before = n++) {
    const Eigen::Vector2d &a = polygon[before], &b = polygon[n];
    if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

void join(Polygon& around, const Polygon& hole) {
  std::size_t from = 0, to = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < around.size(); ++a)
    for (std::size_t h = 0; h < hole.size(); ++h)
      if (const double d = (around[a] - hole[h]).squaredNorm(); d < least) least = d, from = a, to = h;
  Polygon way(hole.begin() + static_cast<std::ptrdiff_t>(to), hole.end());
  way.insert(way.end(), hole.begin(), hole.begin() + static_cast<std::ptrdiff_t>(to) + 1);
  way.push_back(around[from]);
  around.insert(around.begin() + static_cast<std::ptrdiff_t>(from) + 1, way.begin(), way.end());
}

}  // namespace

double doubled_area(const Polygon& polygon) {
  double area = 0;
  for (std::size_t n = 0, before = polygon.size() - 1; n < polygon.size(); before = n++)
    area += polygon[before][0] * polygon[n][1] - polygon[n][0] * polygon[before][1];
  return area;
}

std::vector<std::vector<Polygon>> plane_sections(const SimplexMesh& mesh, const Eigen::Affine3d& index_from_world,
                                                 int planes) {
  const TriangleMesh surface = tessellate(mesh);
  std::vector<Eigen::Vector3d> at;
  at.reserve(surface.positions.size());
  for (const Eigen::Vector3f& p : surface.positions) at.push_back(index_from_world * p.cast<double>());
  const bool mirrored = index_from_world.linear().determinant() < 0;
  std::vector<std::vector<Cut>> cuts(static_cast<std::size_t>(std::max(planes, 0)));
  for (const auto& t : surface.triangles) {
    const auto [low, high] = std::minmax({at[t[0]][2], at[t[1]][2], at[t[2]][2]});
    // A corner on a plane counts as above it, so that every plane goes through edges alone.
    const int first = std::max(0, static_cast<int>(std::floor(std::max(low, -1.0))) + 1);
    for (int k = first; k < planes && k <= high; ++k) {
      std::uint64_t down = 0, up = 0;
      for (int e = 0; e < 3; ++e) {
        const int a = t[e], b = t[(e + 1) % 3];
        if (at[a][2] >= k && at[b][2] < k) down = edge_name(a, b);
        if (at[a][2] < k && at[b][2] >= k) up = edge_name(a, b);
      }
      cuts[static_cast<std::size_t>(k)].push_back(mirrored ? Cut{up, down} : Cut{down, up});
    }
  }
  std::vector<std::vector<Polygon>> sections;
  for (std::size_t k = 0; k < cuts.size(); ++k) sections.push_back(chain(cuts[k], at, static_cast<double>(k)));
  return sections;
}

std::vector<Polygon> with_keyholes(std::vector<Polygon> polygons) {
  const auto hole = std::stable_partition(polygons.begin(), polygons.end(),
                                          [](const Polygon& polygon) { return doubled_area(polygon) > 0; });
  std::vector<Polygon> whole(polygons.begin(), hole), alone = whole;
  for (auto one = hole; one != polygons.end(); ++one) {
    std::size_t nearest = whole.size();
    for (std::size_t w = 0; w < alone.size(); ++w)
      if (contains(alone[w], one->front()) &&
          (nearest == whole.size() || doubled_area(alone[w]) < doubled_area(alone[nearest])))
        nearest = w;
    if (nearest < whole.size())
      join(whole[nearest], *one);
    else
      whole.push_back(*one);  // a part that is turned inside out
  }
  return whole;
}

}  // namespace simplexseg
