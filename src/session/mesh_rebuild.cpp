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

constexpr float kMiddle = 0.5f * kFieldScale;
constexpr double kMostOverWanted = 2;        // vertices, against those that a mesh is to end with
constexpr double kMostForMarks = 32;         // the same, where a mark would end up on the wrong side else
constexpr double kMostToRemesh = 8;          // triangles, against those that are to be left
constexpr float kSure = 0.2f * kFieldScale;  // beyond the middle: P above .7, or below .3

/// The grid of a field, as that of a volume of its own.
VolumeGeometry grid_of(const MeshField& field, const VolumeGeometry& volume) {
  VolumeGeometry grid = volume;
  grid.size = field.box.size;
  grid.origin_mm = volume.world_from_index() * Eigen::Vector3i(field.box.first.data()).cast<double>();
  return grid;
}

/// The field on a grid that is coarser by whole numbers of voxels along each axis: means of what lies within.
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
        // Sure places count no more than near the surface, or thin parts vanish among what is sure to be outside.
        coarse.values[c] += std::clamp(static_cast<float>(field.values[v]) - kMiddle, -kMiddle, kMiddle);
        ++count[c];
      }
  for (std::size_t c = 0; c < count.size(); ++c) coarse.values[c] /= static_cast<float>(count[c]);
  Eigen::Affine3d scale = Eigen::Affine3d::Identity();
  for (int a = 0; a < 3; ++a) scale.linear()(a, a) = step[a], scale.translation()[a] = 0.5 * (step[a] - 1);
  coarse.mm_from_index = grid.world_from_index() * scale;
  return coarse;
}

/// The surface of a field with about `most` vertices, or fewer; without any where the field has no object.
SimplexMesh surface_of(const MeshField& field, const VolumeGeometry& grid, double most) {
  double edge_mm = grid.spacing_mm.minCoeff();
  TriangleMesh surface;
  CoarseField coarse;
  for (int attempt = 0; attempt < 8; ++attempt) {
    coarse = coarsen(field, grid, edge_mm);
    surface = iso_surface(coarse.values, coarse.size, 0, coarse.mm_from_index);
    const double count = static_cast<double>(surface.triangles.size());
    if (count <= kMostToRemesh * most) break;
    edge_mm *= std::max(1.2, std::sqrt(count / (kMostToRemesh * most)));
  }
  if (surface.triangles.empty()) return {};
  // Marching leaves slivers and corners of four to fourteen triangles, whose duals fold.
  const double wanted_mm = std::max(even_edge_mm(surface, most), grid.spacing_mm.minCoeff());
  return even_dual_of(surface, wanted_mm, [&](const Eigen::Vector3d& mm) {
    return onto_iso_surface(coarse.values, coarse.size, 0, coarse.mm_from_index, mm);
  });
}

}  // namespace

FieldDistance distance_to_field(const MeshItem& item, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const MeshField& field = *item.field;
  const VolumeGeometry grid = grid_of(field, volume.geometry());
  const Mask mask = rasterise(item.mesh, grid);
  FieldDistance distance;
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    const float over = static_cast<float>(field.values[v]) - kMiddle;
    distance.object += over > 0;
    distance.wrong += (mask.voxels[v] != 0) != (over > 0) && std::abs(over) > kSure;
  }
  for (const Mark& mark : field.marks) {
    if (mark.kind == MarkKind::Boundary) continue;
    const Eigen::Vector3d at = grid.index_from_world() * mark.position_mm;
    std::array<int, 3> voxel;
    for (int a = 0; a < 3; ++a) voxel[a] = std::clamp(static_cast<int>(std::lround(at[a])), 0, grid.size[a] - 1);
    const std::size_t v = (static_cast<std::size_t>(voxel[2]) * grid.size[1] + voxel[1]) * grid.size[0] + voxel[0];
    distance.wrong_marks += (mask.voxels[v] != 0) != (mark.kind == MarkKind::Inside);
  }
  distance.vertices = item.mesh.vertex_count();
  distance.folded = folded_vertices(item.mesh);
  return distance;
}

bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const int own = item.final_vertices > 0 ? item.final_vertices : static_cast<int>(simulation.final_vertices + 0.5f);
  MeshItem made = item;
  for (const double over : {kMostOverWanted, kMostForMarks}) {
    SimplexMesh mesh = surface_of(*item.field, grid_of(*item.field, volume.geometry()), over * own);
    try {
      if (mesh.positions.empty()) return false;
      validate(mesh);
    } catch (const Error&) {
      return false;
    }
    made.mesh = std::move(mesh);
    if (distance_to_field(made, volume).wrong_marks == 0) break;  // else more vertices
  }
  item = std::move(made);
  item.previous = item.mesh.positions;
  item.edge_mm = mean_edge_mm(item.mesh.positions, item.mesh.neighbours);
  item.shape = shape_reference_of(item.mesh);
  item.profiles.clear();
  item.steps_at_level = 0;
  item.rebuilt = true;
  item.solver = {};
  return true;
}

}  // namespace simplexseg
