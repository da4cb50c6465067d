// SPDX-License-Identifier: Apache-2.0
#include "study/mesh_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/mesh_geometry.h"

namespace simplexseg {

bool all_finite(const SimplexMesh& mesh) {
  return std::all_of(mesh.positions.begin(), mesh.positions.end(),
                     [](const Eigen::Vector3f& p) { return p.allFinite(); });
}

int count_folds(const SimplexMesh& mesh, double margin) {
  const int n = mesh.vertex_count();
  std::vector<Eigen::Vector3d> normals(n, Eigen::Vector3d::Zero());
  for (int i = 0; i < n; ++i) {
    const auto at = [&](int slot) { return mesh.positions[mesh.neighbours[i][slot]].cast<double>().eval(); };
    const Eigen::Vector3d a = at(1) - at(0), b = at(2) - at(0), normal = a.cross(b);
    if (normal.norm() > 1e-3 * a.norm() * b.norm()) normals[i] = normal.normalized();
  }
  int folds = 0;
  for (int i = 0; i < n; ++i)
    folds += std::any_of(mesh.neighbours[i].begin(), mesh.neighbours[i].end(),
                         [&](int k) { return normals[i].dot(normals[k]) < -margin; });
  return folds;
}

bool is_inverted(const SimplexMesh& mesh, double share) {
  const SurfaceMeasures m = measure(mesh);
  return m.volume_mm3 < -share * std::pow(m.area_mm2, 1.5) / (6 * std::sqrt(std::numbers::pi));
}

double farthest_from(const SimplexMesh& mesh, const Eigen::Vector3d& centre_mm) {
  double farthest = 0;
  for (const Eigen::Vector3f& p : mesh.positions) farthest = std::max(farthest, (p.cast<double>() - centre_mm).norm());
  return farthest;
}

Eigen::Vector3d mean_position(const SimplexMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : mesh.positions) sum += p.cast<double>();
  return sum / std::max(1, mesh.vertex_count());
}

}  // namespace simplexseg
