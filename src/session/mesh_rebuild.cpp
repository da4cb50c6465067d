// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_rebuild.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/expect.h"
#include "forces/step_view.h"
#include "image/rasterise.h"
#include "image/volume.h"
#include "mesh/iso_surface.h"
#include "mesh/mesh_geometry.h"
#include "mesh/remesh.h"
#include "mesh/shape_reference.h"

namespace simplexseg {
namespace {

constexpr float kThreshold = 0.5f * kFieldScale;
constexpr double kMaxVertexRatio = 2;             // largest ratio of surface vertices to final vertices of the mesh
constexpr double kMaxVertexRatioForMarks = 32;    // largest ratio if fewer vertices leave a mark on the wrong side
constexpr double kMaxTriangleRatio = 8;           // largest ratio of triangles before remeshing to `max_vertices`
constexpr float kConfident = 0.2f * kFieldScale;  // distance from the threshold: probability above 0.7 or below 0.3

/// Field on a coarser grid, each cell of which covers a whole number of voxels along each axis. Values: means of the
/// field relative to the threshold.
struct CoarseField {
  std::array<int, 3> size;
  std::vector<float> values;
  Eigen::Affine3d mm_from_index;
};
CoarseField coarsen(const MeshField& field, const VolumeGeometry& grid, double edge_mm) {
  std::array<int, 3> step;
  CoarseField coarse;
  for (int a = 0; a < 3; ++a) {
    step[a] = std::max(1, static_cast<int>(std::lround(edge_mm / grid.spacing_mm[a])));
    coarse.size[a] = (field.box.size[a] + step[a] - 1) / step[a];
  }
  const auto [ni, nj, nk] = coarse.size;
  std::vector<int> count(static_cast<std::size_t>(ni) * nj * nk);
  coarse.values.resize(count.size());
  std::size_t v = 0;
  for (int k = 0; k < field.box.size[2]; ++k)
    for (int j = 0; j < field.box.size[1]; ++j)
      for (int i = 0; i < field.box.size[0]; ++i, ++v) {
        const std::size_t c = (static_cast<std::size_t>(k / step[2]) * nj + j / step[1]) * ni + i / step[0];
        // The values are clamped, so that distant background does not outweigh thin parts of the object.
        coarse.values[c] += std::clamp(static_cast<float>(field.values[v]) - kThreshold, -kThreshold, kThreshold);
        ++count[c];
      }
  for (std::size_t c = 0; c < count.size(); ++c) coarse.values[c] /= static_cast<float>(count[c]);
  Eigen::Affine3d scale = Eigen::Affine3d::Identity();
  for (int a = 0; a < 3; ++a) scale.linear()(a, a) = step[a], scale.translation()[a] = 0.5 * (step[a] - 1);
  coarse.mm_from_index = grid.world_from_index() * scale;
  return coarse;
}

/// Surface of a field with at most about `max_vertices` vertices; empty if the field has no object.
SimplexMesh surface_of(const MeshField& field, const VolumeGeometry& grid, double max_vertices) {
  double edge_mm = grid.spacing_mm.minCoeff();
  TriangleMesh surface;
  CoarseField coarse;
  for (int attempt = 0; attempt < 8; ++attempt) {
    coarse = coarsen(field, grid, edge_mm);
    surface = iso_surface(coarse.values, coarse.size, 0, coarse.mm_from_index);
    const double count = static_cast<double>(surface.triangles.size());
    if (count <= kMaxTriangleRatio * max_vertices) break;
    edge_mm *= std::max(1.2, std::sqrt(count / (kMaxTriangleRatio * max_vertices)));
  }
  if (surface.triangles.empty()) return {};
  // Marching tetrahedra produce slivers and vertices with 4 to 14 triangles, whose duals fold; remeshing removes these.
  const double target_mm = std::max(equilateral_edge_mm(surface, max_vertices), grid.spacing_mm.minCoeff());
  return remeshed_dual_of(surface, target_mm, [&](const Eigen::Vector3d& mm) {
    return project_onto_iso_surface(coarse.values, coarse.size, 0, coarse.mm_from_index, mm);
  });
}

}  // namespace

FieldMismatch compare_with_field(const MeshItem& item, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const MeshField& field = *item.field;
  const VolumeGeometry grid = field.grid(volume.geometry());
  const Mask mask = rasterise(item.mesh, grid);
  FieldMismatch mismatch;
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    const float excess = static_cast<float>(field.values[v]) - kThreshold;
    mismatch.object += excess > 0;
    mismatch.wrong += (mask.voxels[v] != 0) != (excess > 0) && std::abs(excess) > kConfident;
  }
  for (const Mark& mark : field.marks) {
    if (mark.kind == MarkKind::Boundary) continue;
    const Eigen::Vector3d at = grid.index_from_world() * mark.position_mm;
    std::array<int, 3> voxel;
    for (int a = 0; a < 3; ++a) voxel[a] = std::clamp(static_cast<int>(std::lround(at[a])), 0, grid.size[a] - 1);
    const std::size_t v = (static_cast<std::size_t>(voxel[2]) * grid.size[1] + voxel[1]) * grid.size[0] + voxel[0];
    mismatch.wrong_marks += (mask.voxels[v] != 0) != (mark.kind == MarkKind::Inside);
  }
  mismatch.vertices = item.mesh.vertex_count();
  mismatch.folded = folded_vertices(item.mesh);
  return mismatch;
}

bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const int final_vertices =
      item.final_vertices > 0 ? item.final_vertices : static_cast<int>(simulation.final_vertices + 0.5f);
  MeshItem rebuilt = item;
  for (const double ratio : {kMaxVertexRatio, kMaxVertexRatioForMarks}) {
    SimplexMesh mesh = surface_of(*item.field, item.field->grid(volume.geometry()), ratio * final_vertices);
    try {
      if (mesh.positions.empty()) return false;
      validate(mesh);
    } catch (const Error&) {
      return false;
    }
    rebuilt.mesh = std::move(mesh);
    if (compare_with_field(rebuilt, volume).wrong_marks == 0) break;  // otherwise the next ratio is tried
  }
  item = std::move(rebuilt);
  item.previous = item.mesh.positions;
  item.edge_mm = mean_edge_mm(item.mesh.positions, item.mesh.neighbours);
  item.shape = shape_reference_of(item.mesh);
  item.profiles.clear();
  item.steps_at_level = 0;
  item.rebuilt = true;
  item.solver = {}, item.sleep = {};
  return true;
}

}  // namespace simplexseg
