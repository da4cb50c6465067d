// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_rebuild.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

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
constexpr double kMaxVertexRatio = 2;           // largest ratio of surface vertices to final vertices of the mesh
constexpr double kMaxVertexRatioForMarks = 32;  // largest ratio if fewer vertices leave a mark on the wrong side
constexpr double kMaxTriangleRatio = 8;         // largest ratio of triangles before remeshing to `max_vertices`
/// Share of the previous disagreement; a mesh is stuck if more than this share remains at the next comparison.
constexpr double kStuckShare = 0.8;
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
SimplexMesh surface_of(const MeshField& field, const VolumeGeometry& grid, double max_vertices,
                       const StopCheck& check_stop) {
  double edge_mm = grid.spacing_mm.minCoeff();
  TriangleMesh surface;
  CoarseField coarse;
  for (int attempt = 0; attempt < 8; ++attempt) {
    if (check_stop) check_stop();
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
    if (check_stop) check_stop();  // remeshing a large surface takes seconds
    return project_onto_iso_surface(coarse.values, coarse.size, 0, coarse.mm_from_index, mm);
  });
}

/// Whether all cells around a cell of the field, up to the sides of its box, are on its side of the threshold. A smooth
/// surface cannot follow single cells.
bool is_surrounded(const MeshField& field, std::size_t cell) {
  const bool inside = field.values[cell] > kThreshold;
  const auto ni = static_cast<std::size_t>(field.box.size[0]), nj = static_cast<std::size_t>(field.box.size[1]);
  const std::array<std::size_t, 3> stride{1, ni, ni * nj}, at{cell % ni, cell / ni % nj, cell / (ni * nj)};
  for (int a = 0; a < 3; ++a) {
    if (at[a] > 0 && (field.values[cell - stride[a]] > kThreshold) != inside) return false;
    if (at[a] + 1 < static_cast<std::size_t>(field.box.size[a]) &&
        (field.values[cell + stride[a]] > kThreshold) != inside)
      return false;
  }
  return true;
}

/// Number of cells outside the box of a field, which is given by its grid, in which a mesh lies by more than a cell.
int cells_outside(const SimplexMesh& mesh, const VolumeGeometry& grid, const Mask& in_box) {
  const Eigen::Affine3d index = grid.index_from_world();
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3i(grid.size.data()).cast<double>();
  const Eigen::Vector3d box_high = high;
  for (const Eigen::Vector3f& p : mesh.positions) {
    const Eigen::Vector3d at = index * p.cast<double>();
    low = low.cwiseMin(at), high = high.cwiseMax(at);
  }
  if ((low.array() >= -1.5).all() && (high.array() <= box_high.array() + 0.5).all()) return 0;
  VolumeGeometry all = grid;
  for (int a = 0; a < 3; ++a) {
    low[a] = std::floor(low[a]);
    all.size[a] = static_cast<int>(std::ceil(high[a]) - low[a]) + 1;
  }
  all.origin_mm = grid.world_from_index() * low;
  const auto set = [](const Mask& mask) { return std::ranges::count(mask.voxels, std::uint8_t{1}); };
  return static_cast<int>(set(rasterise(mesh, all)) - set(in_box));
}

FieldMismatch mismatch_of(const SimplexMesh& mesh, const MeshField& field, const Volume& volume) {
  const VolumeGeometry grid = field.grid(volume.geometry());
  const Mask mask = rasterise(mesh, grid);
  FieldMismatch mismatch;
  mismatch.wrong = cells_outside(mesh, grid, mask);
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
  for (const std::uint32_t v : field.painted_cells)
    mismatch.wrong_marks += is_surrounded(field, v) && (mask.voxels[v] != 0) != (field.values[v] > kThreshold);
  mismatch.vertices = mesh.vertex_count();
  mismatch.folded = folded_vertices(mesh);
  return mismatch;
}

}  // namespace

FieldMismatch compare_with_field(const MeshItem& item, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  return mismatch_of(item.mesh, *item.field, volume);
}

std::optional<RebuiltMesh> surface_of_field(const MeshItem& item, const SimulationParameters& simulation,
                                            const Volume& volume, const StopCheck& check_stop) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const int final_vertices =
      item.final_vertices > 0 ? item.final_vertices : static_cast<int>(simulation.final_vertices + 0.5f);
  RebuiltMesh rebuilt;
  for (const double ratio : {kMaxVertexRatio, kMaxVertexRatioForMarks}) {
    SimplexMesh mesh = surface_of(*item.field, item.field->grid(volume.geometry()), ratio * final_vertices, check_stop);
    try {
      if (mesh.positions.empty()) return std::nullopt;
      validate(mesh);
    } catch (const Error&) {
      return std::nullopt;
    }
    rebuilt.mesh = std::move(mesh);
    rebuilt.mismatch = mismatch_of(rebuilt.mesh, *item.field, volume);
    if (rebuilt.mismatch.wrong_marks == 0) break;  // otherwise the next ratio is tried
  }
  rebuilt.edge_mm = mean_edge_mm(rebuilt.mesh.positions, rebuilt.mesh.neighbours);
  rebuilt.shape = shape_reference_of(rebuilt.mesh);
  return rebuilt;
}

void replace_mesh(MeshItem& item, RebuiltMesh rebuilt) {
  item.mesh = std::move(rebuilt.mesh);
  item.previous = item.mesh.positions;
  item.edge_mm = rebuilt.edge_mm;
  item.shape = std::move(rebuilt.shape);
  item.profiles.clear();
  item.steps_at_level = 0;
  item.rebuilt = true;
  item.solver = {}, item.sleep = {};
}

bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  std::optional<RebuiltMesh> rebuilt = surface_of_field(item, simulation, volume);
  if (!rebuilt) return false;
  replace_mesh(item, *std::move(rebuilt));
  return true;
}

FieldComparison compare_and_rebuild(const MeshItem& item, bool settled, const SimulationParameters& simulation,
                                    const Volume& volume, const StopCheck& check_stop) {
  if (check_stop) check_stop();
  const int before = item.fit.field == item.field ? item.fit.disagreement : std::numeric_limits<int>::max();
  const FieldMismatch mismatch = compare_with_field(item, volume);
  const bool stuck = !mismatch.matches() && mismatch.disagreement() > kStuckShare * before;
  FieldComparison comparison{{item.field, mismatch.disagreement(), settled || stuck}, std::nullopt};
  if (mismatch.matches() || !comparison.fit.settled) return comparison;
  std::optional<RebuiltMesh> rebuilt = surface_of_field(item, simulation, volume, check_stop);
  if (rebuilt && rebuilt->mismatch.better_than(mismatch)) comparison.rebuilt = std::move(rebuilt);
  return comparison;
}

}  // namespace simplexseg
