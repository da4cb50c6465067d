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
#include "mesh/shape_reference.h"

namespace simplexseg {
namespace {

constexpr float kMiddle = 0.5f * kFieldScale;
constexpr double kMostOverWanted = 2;  // vertices, against those that a mesh is to end with
constexpr int kRelaxations = 10;

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

/// Draws vertices to the middle of their neighbours and back (Taubin 1995), so that they spread without shrinking.
void relax(SimplexMesh& mesh) {
  std::vector<Eigen::Vector3f> moved(mesh.positions.size());
  for (int pass = 0; pass < 2 * kRelaxations; ++pass) {
    const float share = pass % 2 == 0 ? 0.6f : -0.63f;
    for (std::size_t v = 0; v < moved.size(); ++v) {
      const std::array<int, 3>& n = mesh.neighbours[v];
      const Eigen::Vector3f middle = (mesh.positions[n[0]] + mesh.positions[n[1]] + mesh.positions[n[2]]) / 3;
      moved[v] = mesh.positions[v] + share * (middle - mesh.positions[v]);
    }
    mesh.positions.swap(moved);
  }
}

}  // namespace

int deep_disagreement(const MeshItem& item, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const MeshField& field = *item.field;
  Mask mask = rasterise(item.mesh, grid_of(field, volume.geometry()));
  const std::vector<std::uint8_t> object = field.object_voxels();
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) mask.voxels[v] = mask.voxels[v] != object[v];
  const auto [ni, nj, nk] = field.box.size;
  int deep = 0;
  for (int k = 1; k + 1 < nk; ++k)
    for (int j = 1; j + 1 < nj; ++j) {
      const std::size_t row = (static_cast<std::size_t>(k) * nj + j) * ni, plane = static_cast<std::size_t>(ni) * nj;
      for (std::size_t v = row + 1; v + 1 < row + ni; ++v)
        deep += mask.voxels[v] && mask.voxels[v - 1] && mask.voxels[v + 1] && mask.voxels[v - ni] &&
                mask.voxels[v + ni] && mask.voxels[v - plane] && mask.voxels[v + plane];
    }
  return deep;
}

bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  SIMPLEXSEG_EXPECT(item.has_field());
  const VolumeGeometry grid = grid_of(*item.field, volume.geometry());
  const int own = item.final_vertices > 0 ? item.final_vertices : static_cast<int>(simulation.final_vertices + 0.5f);
  const double most = kMostOverWanted * own;
  double edge_mm = grid.spacing_mm.minCoeff();
  TriangleMesh surface;
  for (int attempt = 0; attempt < 8; ++attempt) {
    const CoarseField coarse = coarsen(*item.field, grid, edge_mm);
    surface = iso_surface(coarse.values, coarse.size, 0, coarse.mm_from_index);
    const double count = static_cast<double>(surface.triangles.size());
    if (count <= most) break;
    edge_mm *= std::max(1.2, std::sqrt(count / most));
  }
  if (surface.triangles.empty()) return false;
  SimplexMesh mesh = dual_of(surface);
  relax(mesh);
  try {
    validate(mesh);
  } catch (const Error&) {
    return false;
  }
  item.mesh = std::move(mesh);
  item.previous = item.mesh.positions;
  item.shape = shape_reference_of(item.mesh);
  item.profiles.clear();
  item.steps_at_level = 0;
  item.rebuilt = true;
  item.solver = {};
  return true;
}

}  // namespace simplexseg
