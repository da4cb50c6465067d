// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/polygon_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <utility>

#include "core/error.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

constexpr double kMaxVolumeLoss = 0.02;             ///< of the dual of a triangulation, as a fraction of its volume
constexpr std::size_t kMaxSplitTriangles = 100000;  ///< larger triangulations are not split further
constexpr int kMaxSplits = 6;
constexpr std::size_t kMaxClipped = 200;  ///< corners of the largest polygon that is split by ear clipping

bool are_triangles(const CellList& polygons) {
  for (int c = 0; c < polygons.count(); ++c)
    if (polygons[c].size() != 3) return false;
  return true;
}

/// Whether each vertex belongs to three polygons, as in a simplex mesh.
bool are_cells(const PolygonSurface& surface) {
  std::vector<int> count(surface.positions.size());
  for (const int v : surface.polygons.vertices) ++count[v];
  return std::all_of(count.begin(), count.end(), [](int n) { return n == 3; });
}

/// Merges vertices with equal positions.
void weld(PolygonSurface& surface) {
  std::map<std::array<float, 3>, int> places;
  std::vector<Eigen::Vector3f> positions;
  std::vector<int> index;
  for (const Eigen::Vector3f& p : surface.positions) {
    const auto [found, is_new] = places.try_emplace({p[0], p[1], p[2]}, static_cast<int>(positions.size()));
    if (is_new) positions.push_back(p);
    index.push_back(found->second);
  }
  surface.positions = std::move(positions);
  for (int& v : surface.polygons.vertices) v = index[v];
}

/// Whether a polygon, of which `corners` remain, can be cut along the triangle at corner `tip` without leaving it.
/// `normal`: direction of its vector area.
bool is_ear(const std::vector<Eigen::Vector3f>& positions, const std::vector<int>& corners, std::size_t tip,
            const Eigen::Vector3d& normal) {
  const std::size_t count = corners.size();
  const auto place = [&](std::size_t n) {
    return Eigen::Vector3d(positions[static_cast<std::size_t>(corners[n % count])].cast<double>());
  };
  const Eigen::Vector3d a = place(tip + count - 1), b = place(tip), c = place(tip + 1);
  const auto side = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& point) {
    return normal.dot((to - from).cross(point - from));
  };
  if (!(side(a, b, c) > 0)) return false;
  for (std::size_t n = 2; n + 1 < count; ++n) {
    const Eigen::Vector3d point = place(tip + n);
    if (point == a || point == b || point == c) continue;
    if (side(a, b, point) >= 0 && side(b, c, point) >= 0 && side(c, a, point) >= 0) return false;
  }
  return true;
}

/// Triangles of a polygon by ear clipping (Meisters 1975): from its first corner if it is convex, has no ear, or has
/// more than kMaxClipped corners.
std::vector<std::array<int, 3>> triangles_of_polygon(const std::vector<Eigen::Vector3f>& positions,
                                                     std::span<const int> polygon) {
  std::vector<int> corners(polygon.begin(), polygon.end());
  const auto place = [&](std::size_t n) {
    return Eigen::Vector3d(positions[static_cast<std::size_t>(polygon[n])].cast<double>());
  };
  Eigen::Vector3d normal(0, 0, 0);
  for (std::size_t n = 2; n < polygon.size(); ++n) normal += (place(n - 1) - place(0)).cross(place(n) - place(0));
  std::vector<std::array<int, 3>> triangles;
  bool clips = polygon.size() <= kMaxClipped;
  while (corners.size() >= 3) {
    const std::size_t count = corners.size();
    std::size_t tip = 1;
    if (clips && count > 3) {
      while (tip <= count && !is_ear(positions, corners, tip % count, normal)) ++tip;
      clips = tip <= count;
      tip = clips ? tip % count : 1;
    }
    triangles.push_back({corners[(tip + count - 1) % count], corners[tip], corners[(tip + 1) % count]});
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(tip));
  }
  return triangles;
}

TriangleMesh triangles_of(const PolygonSurface& surface) {
  TriangleMesh triangles{surface.positions, {}};
  for (int c = 0; c < surface.polygons.count(); ++c) {
    const auto polygon = surface.polygons[c];
    const auto add = [&](const std::array<int, 3>& t) {
      // A triangle with two identical corners is omitted: the surface is closed without it.
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.triangles.push_back(t);
    };
    if (polygon.size() == 3)
      add({polygon[0], polygon[1], polygon[2]});
    else
      std::ranges::for_each(triangles_of_polygon(surface.positions, polygon), add);
  }
  return triangles;
}

/// Corners of a triangle relative to a point, in double precision.
std::array<Eigen::Vector3d, 3> corners_of(const TriangleMesh& surface, const std::array<int, 3>& triangle,
                                          const Eigen::Vector3d& origin) {
  const auto corner = [&](int n) {
    return Eigen::Vector3d(
        surface.positions[static_cast<std::size_t>(triangle[static_cast<std::size_t>(n)])].cast<double>() - origin);
  };
  return {corner(0), corner(1), corner(2)};
}

/// Enclosed volume, mm^3; > 0 if the triangles face outward.
double volume_of(const TriangleMesh& surface) {
  const Eigen::Vector3d origin = surface.positions.front().cast<double>();
  double sixfold = 0;
  for (const auto& triangle : surface.triangles) {
    const auto [a, b, c] = corners_of(surface, triangle, origin);
    sixfold += a.dot(b.cross(c));
  }
  return sixfold / 6;
}

/// Splits each triangle into four at the midpoints of its sides, which leaves the surface as it is.
TriangleMesh split_triangles(const TriangleMesh& coarse) {
  TriangleMesh fine{coarse.positions, {}};
  fine.triangles.reserve(4 * coarse.triangles.size());
  std::map<std::pair<int, int>, int> midpoints;
  const auto midpoint = [&](int a, int b) {
    const std::pair<int, int> side(std::min(a, b), std::max(a, b));
    const auto [found, is_new] = midpoints.try_emplace(side, static_cast<int>(fine.positions.size()));
    if (is_new) {
      const Eigen::Vector3f middle =
          0.5f * coarse.positions[static_cast<std::size_t>(a)] + 0.5f * coarse.positions[static_cast<std::size_t>(b)];
      fine.positions.push_back(middle);
    }
    return found->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const int ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
    const std::array<std::array<int, 3>, 4> parts{{{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}};
    fine.triangles.insert(fine.triangles.end(), parts.begin(), parts.end());
  }
  return fine;
}

/// Closed part of a surface.
struct Part {
  double volume_mm3 = 0;  ///< < 0 if it faces inward
  Eigen::Vector3d point;  ///< a point of the part
  Eigen::AlignedBox3d box;
  std::vector<std::array<int, 3>> triangles;
};

/// Whether `part` of a surface encloses a point, by its winding number (van Oosterom and Strackee 1983).
bool encloses(const TriangleMesh& surface, const Part& part, const Eigen::Vector3d& point) {
  double solid_angle = 0;
  for (const auto& triangle : part.triangles) {
    const auto [a, b, c] = corners_of(surface, triangle, point);
    const double na = a.norm(), nb = b.norm(), nc = c.norm();
    solid_angle += 2 * std::atan2(a.dot(b.cross(c)), na * nb * nc + a.dot(b) * nc + b.dot(c) * na + c.dot(a) * nb);
  }
  return std::abs(solid_angle) > 2 * std::numbers::pi;
}

/// Whether the outermost part around each part, or the part itself if there is none, faces inward.
std::vector<bool> within_inward_part(const TriangleMesh& surface, const std::vector<Part>& parts) {
  std::vector<bool> within;
  if (std::none_of(parts.begin(), parts.end(), [](const Part& p) { return p.volume_mm3 < 0; })) {
    within.resize(parts.size());
    return within;
  }
  for (const Part& part : parts) {
    const Part* outermost = &part;
    for (const Part& other : parts) {
      if (std::abs(other.volume_mm3) > std::abs(outermost->volume_mm3) && other.box.contains(part.box) &&
          encloses(surface, other, part.point))
        outermost = &other;
    }
    within.push_back(outermost->volume_mm3 < 0);
  }
  return within;
}

/// Number of the connected part of each vertex, from 0; their count.
std::pair<std::vector<int>, std::size_t> number_parts(const SimplexMesh& mesh) {
  std::vector<int> part_of(mesh.positions.size(), -1), pending;
  int count = 0;
  for (int start = 0; start < mesh.vertex_count(); ++start) {
    if (part_of[static_cast<std::size_t>(start)] >= 0) continue;
    pending = {start};
    while (!pending.empty()) {
      const auto vertex = static_cast<std::size_t>(pending.back());
      pending.pop_back();
      if (part_of[vertex] >= 0) continue;
      part_of[vertex] = count;
      pending.insert(pending.end(), mesh.neighbours[vertex].begin(), mesh.neighbours[vertex].end());
    }
    ++count;
  }
  return {std::move(part_of), static_cast<std::size_t>(count)};
}

/// Vertices whose part must be turned so that every outermost part faces outward. Parts inside another keep their
/// orientation relative to it, so that cavities stay cavities.
std::vector<bool> vertices_to_turn(const SimplexMesh& mesh) {
  const auto [part_of, count] = number_parts(mesh);
  const TriangleMesh surface = tessellate(mesh);
  std::vector<Part> parts(count);
  const Eigen::Vector3d origin = surface.positions.front().cast<double>();
  for (const auto& triangle : surface.triangles) {
    const auto corner = static_cast<std::size_t>(triangle[1]);  // a vertex of the mesh; triangle[0] is a cell's centre
    Part& part = parts[static_cast<std::size_t>(part_of[corner])];
    const auto [a, b, c] = corners_of(surface, triangle, origin);
    part.volume_mm3 += a.dot(b.cross(c)) / 6;
    part.point = surface.positions[corner].cast<double>();
    part.box.extend(part.point);
    if (count > 1) part.triangles.push_back(triangle);
  }
  const std::vector<bool> turned = within_inward_part(surface, parts);
  std::vector<bool> result;
  result.reserve(part_of.size());
  for (const int part : part_of) result.push_back(turned[static_cast<std::size_t>(part)]);
  return result;
}

/// Dual of a triangulation whose volume differs from that of the triangulation by at most kMaxVolumeLoss, if
/// kMaxSplits and kMaxSplitTriangles allow it. `turned`: triangles that must be turned.
SimplexMesh dual_with_volume(TriangleMesh surface, SimplexMesh mesh, const std::vector<bool>& turned) {
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (turned[t]) std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  const double volume_mm3 = volume_of(surface);
  for (int split = 0; split < kMaxSplits && surface.triangles.size() <= kMaxSplitTriangles &&
                      std::abs(measure(mesh).volume_mm3 - volume_mm3) > kMaxVolumeLoss * std::abs(volume_mm3);
       ++split) {
    surface = split_triangles(surface);
    mesh = dual_of(surface);
  }
  return mesh;
}

void turn(SimplexMesh& mesh, const std::vector<bool>& turned) {
  for (std::size_t v = 0; v < mesh.neighbours.size(); ++v)
    if (turned[v]) std::swap(mesh.neighbours[v][1], mesh.neighbours[v][2]);
}

}  // namespace

bool states_ras(std::string_view comments) { return comments.find("SPACE=RAS") != std::string_view::npos; }

void convert_from_ras(std::vector<Eigen::Vector3f>& positions) {
  for (Eigen::Vector3f& p : positions) p.head<2>() *= -1;
}

std::vector<std::array<int, 3>> neighbours_of(const PolygonSurface& surface, const Fail& fail) {
  // In a polygon with consecutive corners a, v, b, the edge to a follows the edge to b counter-clockwise around v.
  struct Turn {
    int from, to;
  };
  const std::size_t vertices = surface.positions.size();
  std::vector<std::array<Turn, 3>> turns(vertices);
  std::vector<int> filled(vertices, 0);
  for (int c = 0; c < surface.polygons.count(); ++c) {
    const auto cell = surface.polygons[c];
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const int v = cell[i];
      if (filled[v] == 3) fail("vertex " + std::to_string(v) + " belongs to more than three polygons");
      turns[v][filled[v]++] = {cell[(i + 1) % cell.size()], cell[(i + cell.size() - 1) % cell.size()]};
    }
  }
  std::vector<std::array<int, 3>> neighbours(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    if (filled[v] != 3)
      fail("vertex " + std::to_string(v) + " belongs to " + std::to_string(filled[v]) + " polygons instead of three");
    const auto& t = turns[v];
    // The three turns must form a cycle: first.to == second.from and so on, in one of the two orders.
    const int second = t[1].from == t[0].to ? 1 : 2, third = 3 - second;
    if (t[second].from != t[0].to || t[third].from != t[second].to || t[0].from != t[third].to) {
      fail("the polygons around vertex " + std::to_string(v) + " do not close");
    }
    neighbours[v] = {t[0].from, t[second].from, t[third].from};
  }
  return neighbours;
}

SimplexMesh simplex_mesh_of(PolygonSurface surface, const Fail& fail) {
  if (surface.polygons.count() == 0) fail("it has no polygons");
  for (const Eigen::Vector3f& p : surface.positions)
    if (!p.allFinite()) fail("a position is not finite");
  SimplexMesh mesh;
  if (!are_triangles(surface.polygons) && are_cells(surface)) {
    mesh.neighbours = neighbours_of(surface, fail);
    mesh.positions = std::move(surface.positions);
    turn(mesh, vertices_to_turn(mesh));
  } else {
    if (surface.positions.size() == surface.polygons.vertices.size()) weld(surface);
    TriangleMesh triangles = triangles_of(surface);
    try {
      mesh = dual_of(triangles);
    } catch (const Error& error) {
      const std::string why = error.what();  // without the remedy: `fail` adds another one
      fail(why.substr(0, why.rfind("; ")));
    }
    const std::vector<bool> turned = vertices_to_turn(mesh);
    turn(mesh, turned);
    mesh = dual_with_volume(std::move(triangles), std::move(mesh), turned);
  }
  return mesh;
}

}  // namespace simplexseg
