// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

// Neighbours are collinear, up to rounding of float positions, if |N| is at most this share of the squared longest
// side.
constexpr double kCollinear = 1e-6;

/// Positions of the three neighbours and N = (P2-P1) x (P3-P1).
struct Neighbours {
  Vector3d p1, p2, p3, cross;
};

Neighbours neighbours_of(const SimplexMesh& mesh, int vertex) {
  const auto& n = mesh.neighbours[vertex];
  Neighbours f{position_of(mesh, n[0]), position_of(mesh, n[1]), position_of(mesh, n[2]), Vector3d::Zero()};
  f.cross = (f.p2 - f.p1).cross(f.p3 - f.p1);
  return f;
}

/// Longer of two vectors; the first one on a tie.
const Vector3d& longer(const Vector3d& a, const Vector3d& b) { return a.squaredNorm() >= b.squaredNorm() ? a : b; }

/// Unit vector orthogonal to the line of collinear neighbours, as close as possible to the sum of their vectors N.
Vector3d collinear_normal(const SimplexMesh& mesh, int vertex, const Vector3d& longest_side) {
  Vector3d reference = Vector3d::Zero();
  for (int w : mesh.neighbours[vertex]) reference += neighbours_of(mesh, w).cross;
  const double length = reference.norm();
  if (length > 0.0) reference /= length;
  if (longest_side.squaredNorm() == 0.0) return length > 0.0 ? reference : Vector3d::UnitZ();
  const Vector3d line = longest_side.normalized();
  const Vector3d orthogonal = reference - reference.dot(line) * line;
  return orthogonal.norm() > kCollinear ? orthogonal.normalized() : line.unitOrthogonal();
}

Vector3d mean_position(const SimplexMesh& mesh) {
  Vector3d sum = Vector3d::Zero();
  for (const auto& p : mesh.positions) sum += p.cast<double>();
  return mesh.positions.empty() ? sum : Vector3d(sum / static_cast<double>(mesh.positions.size()));
}

/// Calls visit(C, a, b) for each edge (a, b) of each cell with the cell's centre C.
template <typename Visit>
void for_each_triangle(const SimplexMesh& mesh, const Visit& visit) {
  const CellList cells = cells_of(mesh);
  for (int c = 0; c < cells.count(); ++c) {
    const auto cell = cells[c];
    Vector3d centre = Vector3d::Zero();
    for (int v : cell) centre += position_of(mesh, v);
    centre /= static_cast<double>(cell.size());
    for (std::size_t i = 0; i < cell.size(); ++i) visit(centre, cell[i], cell[i + 1 == cell.size() ? 0 : i + 1]);
  }
}

}  // namespace

TriangleMesh tessellate(const SimplexMesh& mesh) {
  const CellList cells = cells_of(mesh);
  TriangleMesh result;
  result.positions = mesh.positions;
  result.positions.reserve(mesh.positions.size() + cells.count());
  result.triangles.reserve(cells.vertices.size());
  for (int c = 0; c < cells.count(); ++c) {
    const auto cell = cells[c];
    const int centre_index = static_cast<int>(result.positions.size());
    Vector3d centre = Vector3d::Zero();
    for (int v : cell) centre += position_of(mesh, v);
    result.positions.push_back((centre / static_cast<double>(cell.size())).cast<float>());
    for (std::size_t i = 0; i < cell.size(); ++i)
      result.triangles.push_back({centre_index, cell[i], cell[i + 1 == cell.size() ? 0 : i + 1]});
  }
  return result;
}

VertexGeometry vertex_geometry(const SimplexMesh& mesh, int vertex) {
  SIMPLEXSEG_EXPECT(vertex >= 0 && vertex < mesh.vertex_count());
  const Vector3d p = position_of(mesh, vertex);
  const Neighbours f = neighbours_of(mesh, vertex);
  const Vector3d a = f.p2 - f.p1, b = f.p3 - f.p1, c = f.p3 - f.p2;
  const Vector3d longest = longer(longer(a, b), c);
  VertexGeometry g;
  g.doubled_area_mm2 = f.cross.norm();
  if (!(g.doubled_area_mm2 > kCollinear * longest.squaredNorm())) {
    g.normal = collinear_normal(mesh, vertex, longest);
    g.elevation_mm = (p - f.p1).dot(g.normal);
    g.mean_curvature = 0.0;  // r is infinite
    // The barycentric coordinates of the foot's projection on the line are not unique. Uses those nearest to
    // (1, 1, 1)/3.
    const Vector3d mean = (f.p1 + f.p2 + f.p3) / 3.0;
    const Vector3d line = longest.normalized();
    const Vector3d along((f.p1 - mean).dot(line), (f.p2 - mean).dot(line), (f.p3 - mean).dot(line));
    g.metric = Vector3d::Constant(1.0 / 3.0);
    if (along.squaredNorm() > 0.0)
      g.metric += (p - g.elevation_mm * g.normal - mean).dot(line) / along.squaredNorm() * along;
    return g;
  }
  const double square = f.cross.squaredNorm();
  g.normal = f.cross / g.doubled_area_mm2;
  g.elevation_mm = (p - f.p1).dot(g.normal);
  const Vector3d foot = p - g.elevation_mm * g.normal;
  g.metric[0] = f.cross.dot(c.cross(foot - f.p2)) / square;
  g.metric[1] = f.cross.dot((-b).cross(foot - f.p3)) / square;
  g.metric[2] = f.cross.dot(a.cross(foot - f.p1)) / square;
  // sin(phi)/r = 1/R of the sphere through the vertex and its neighbours. Its centre is z above the circumcentre C,
  // z = (h^2 + d^2 - r^2)/(2h), and R^2 = r^2 + z^2.
  const Vector3d to_circumcentre =
      (b.squaredNorm() * f.cross.cross(a) + a.squaredNorm() * b.cross(f.cross)) / (2.0 * square);
  const double r2 = to_circumcentre.squaredNorm();
  const double d2 = (foot - f.p1 - to_circumcentre).squaredNorm();
  const double h = g.elevation_mm, power = h * h + d2 - r2;
  const double root = std::sqrt(4.0 * h * h * r2 + power * power);
  g.mean_curvature = root > 0.0 ? 2.0 * h / root : 0.0;
  return g;
}

SurfaceMeasures measure(const SimplexMesh& mesh) {
  SurfaceMeasures m{};
  if (mesh.positions.empty()) return m;
  // Positions are relative to the mean of the vertices, which avoids cancellation in the volumes far from the origin.
  const Vector3d origin = mean_position(mesh);
  Vector3d moment = Vector3d::Zero();
  for_each_triangle(mesh, [&](const Vector3d& centre, int ia, int ib) {
    const Vector3d a = position_of(mesh, ia) - origin, b = position_of(mesh, ib) - origin, c = centre - origin;
    const double volume = c.dot(a.cross(b)) / 6.0;
    m.area_mm2 += 0.5 * (a - c).cross(b - c).norm();
    m.volume_mm3 += volume;
    moment += volume / 4.0 * (a + b + c);
  });
  const bool has_volume = std::abs(m.volume_mm3) > 1e-12 * std::pow(m.area_mm2, 1.5);
  m.centroid_mm = has_volume ? Vector3d(origin + moment / m.volume_mm3) : origin;
  double sum = 0.0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int w : mesh.neighbours[v]) sum += (mesh.positions[w] - mesh.positions[v]).cast<double>().norm();
  m.mean_edge_mm = sum / (3.0 * mesh.vertex_count());
  return m;
}

float mean_edge_mm(std::span<const Eigen::Vector3f> positions, std::span<const std::array<int, 3>> neighbours) {
  SIMPLEXSEG_EXPECT(positions.size() == neighbours.size());
  double sum = 0;
  for (std::size_t v = 0; v < positions.size(); ++v)
    for (int w : neighbours[v]) sum += (positions[w] - positions[v]).norm();
  return positions.empty() ? 0.0f : static_cast<float>(sum / (3.0 * static_cast<double>(positions.size())));
}

std::vector<double> vertex_areas(const SimplexMesh& mesh) {
  std::vector<double> areas(mesh.positions.size(), 0.0);
  for_each_triangle(mesh, [&](const Vector3d& centre, int a, int b) {
    const double half = 0.25 * (position_of(mesh, a) - centre).cross(position_of(mesh, b) - centre).norm();
    areas[a] += half;
    areas[b] += half;
  });
  return areas;
}

int folded_vertices(const SimplexMesh& mesh) {
  std::vector<Vector3d> normals(mesh.positions.size());
  for (int v = 0; v < mesh.vertex_count(); ++v) normals[v] = vertex_geometry(mesh, v).normal;
  int folded = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    folded += std::any_of(mesh.neighbours[v].begin(), mesh.neighbours[v].end(),
                          [&](int n) { return normals[v].dot(normals[n]) < 0; });
  return folded;
}

}  // namespace simplexseg
