// SPDX-License-Identifier: Apache-2.0
#include "mesh/shape_reference.h"

#include <cmath>

#include "core/expect.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {

std::vector<Vec4> shape_reference_of(const SimplexMesh& mesh) {
  SIMPLEXSEG_EXPECT(mesh.neighbours.size() == mesh.positions.size());
  constexpr double kMaxSum = 5.0;
  std::vector<Vec4> reference(mesh.positions.size());
  for (int i = 0; i < mesh.vertex_count(); ++i) {
    const VertexGeometry g = vertex_geometry(mesh, i);
    Eigen::Vector3d e = g.metric;
    if (!e.allFinite()) e.setConstant(1.0 / 3);
    const double sum = e.cwiseAbs().sum();
    if (sum > kMaxSum) {
      const double t = (kMaxSum - 1.0) / (sum - 1.0);
      e = Eigen::Vector3d::Constant((1 - t) / 3) + t * e;
    }
    reference[i] = {float(e[0]), float(e[1]), float(g.elevation_mm), float(g.doubled_area_mm2)};
  }
  return reference;
}

}  // namespace simplexseg
