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

constexpr double kMinArea = 1e-6;  // polygons with a smaller doubled_area() are omitted, square voxels

/// Intersection of a triangle with a plane, from the triangle's edge that crosses the plane downwards to the edge that
/// crosses it upwards, so that the solid lies to the left. The key of an edge consists of its ends, the smaller index
/// first.
struct Cut {
  std::uint64_t from, to;
};

std::uint64_t edge_key(int a, int b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
}

/// Joins the cuts in one plane, at k = `height`, into closed polygons. Each crossed edge is the start of one cut.
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
    if (polygon.size() > 2 && std::abs(doubled_area(polygon)) > kMinArea) polygons.push_back(std::move(polygon));
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

/// Joins a hole to the polygon around it by a channel between their nearest corners.
void join(Polygon& around, const Polygon& hole) {
  std::size_t from = 0, to = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < around.size(); ++a)
    for (std::size_t h = 0; h < hole.size(); ++h)
      if (const double d = (around[a] - hole[h]).squaredNorm(); d < smallest) smallest = d, from = a, to = h;
  Polygon detour(hole.begin() + static_cast<std::ptrdiff_t>(to), hole.end());
  detour.insert(detour.end(), hole.begin(), hole.begin() + static_cast<std::ptrdiff_t>(to) + 1);
  detour.push_back(around[from]);
  around.insert(around.begin() + static_cast<std::ptrdiff_t>(from) + 1, detour.begin(), detour.end());
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
    // A corner on a plane counts as above the plane, so that planes cross edges only.
    const int first = std::max(0, static_cast<int>(std::floor(std::max(low, -1.0))) + 1);
    for (int k = first; k < planes && k <= high; ++k) {
      std::uint64_t down = 0, up = 0;
      for (int e = 0; e < 3; ++e) {
        const int a = t[e], b = t[(e + 1) % 3];
        if (at[a][2] >= k && at[b][2] < k) down = edge_key(a, b);
        if (at[a][2] < k && at[b][2] >= k) up = edge_key(a, b);
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
  std::vector<Polygon> joined(polygons.begin(), hole), outer = joined;
  for (auto one = hole; one != polygons.end(); ++one) {
    std::size_t nearest = joined.size();
    for (std::size_t w = 0; w < outer.size(); ++w)
      if (contains(outer[w], one->front()) &&
          (nearest == joined.size() || doubled_area(outer[w]) < doubled_area(outer[nearest])))
        nearest = w;
    if (nearest < joined.size())
      join(joined[nearest], *one);
    else
      joined.push_back(*one);  // not inside any polygon: a part with reversed orientation
  }
  return joined;
}

}  // namespace simplexseg
