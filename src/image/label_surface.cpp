// SPDX-License-Identifier: Apache-2.0
#include "image/label_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/expect.h"
#include "image/gaussian.h"
#include "mesh/iso_surface.h"
#include "mesh/mesh_geometry.h"
#include "mesh/remesh.h"

namespace simplexseg {
namespace {

constexpr int kReach = 3;             // margin for the smoothing, voxels
constexpr float kMinMargin = 0.12f;   // smallest difference of a voxel from the threshold (0.19 at a flat face)
constexpr double kEdgeVoxels = 1.25;  // default edge length of the triangles, voxels
constexpr int kPasses = 10;           // relaxation passes
constexpr double kRelaxation = 0.5;   // relaxation factor of a pass
constexpr double kMaxOffset = 0.3;    // largest displacement for restoring the volume, voxels

/// Smoothed mask on a box with a margin for the smoothing.
struct SmoothedMask {
  VoxelBox box;
  std::vector<float> values;  ///< difference from the threshold, positive inside
  Eigen::Affine3d mm_from_index;
};

VoxelBox box_around(const Mask& mask) {
  VoxelBox box = bounding_box(mask, mask);
  for (int a = 0; a < 3; ++a) box.first[a] -= kReach, box.size[a] += 2 * kReach;
  return box;
}

/// Calls f(offset in the box, value) for each voxel of the box that lies in the grid of the mask.
template <class F>
void each_voxel(const Mask& mask, const VoxelBox& box, F&& f) {
  const auto [ni, nj, nk] = mask.geometry.size;
  for (int k = std::max(0, -box.first[2]); k < std::min(box.size[2], nk - box.first[2]); ++k)
    for (int j = std::max(0, -box.first[1]); j < std::min(box.size[1], nj - box.first[1]); ++j)
      for (int i = std::max(0, -box.first[0]); i < std::min(box.size[0], ni - box.first[0]); ++i)
        f(box.offset(i, j, k),
          mask.voxels[(static_cast<std::size_t>(k + box.first[2]) * nj + j + box.first[1]) * ni + i + box.first[0]]);
}

SmoothedMask smoothed(const Mask& mask) {
  SmoothedMask field;
  field.box = box_around(mask);
  std::vector<std::uint8_t> inside(field.box.voxel_count());
  each_voxel(mask, field.box, [&](std::size_t at, std::uint8_t set) { inside[at] = set; });
  field.values = smoothed_voxels(inside, field.box);
  for (std::size_t v = 0; v < inside.size(); ++v) {
    const float excess = field.values[v] - 0.5f;
    field.values[v] = inside[v] ? std::max(excess, kMinMargin) : std::min(excess, -kMinMargin);
  }
  field.mm_from_index = mask.geometry.world_from_index();
  field.mm_from_index.translate(Eigen::Vector3i(field.box.first.data()).cast<double>());
  return field;
}

/// Moves each vertex tangentially towards the mean of its neighbours, since the local frame of the shape memory force
/// is ill-defined where neighbours are collinear or in reverse order.
void relax(SimplexMesh& mesh, const SurfaceProjection& project) {
  for (int pass = 0; pass < kPasses; ++pass) {
    const SimplexMesh before = mesh;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3d at = before.positions[v].cast<double>(), normal = vertex_geometry(before, v).normal;
      Eigen::Vector3d move = -at;
      for (const int n : before.neighbours[v]) move += before.positions[n].cast<double>() / 3;
      move -= move.dot(normal) * normal;
      mesh.positions[v] = project(at + kRelaxation * move).cast<float>();
    }
  }
}

/// Moves all vertices along their normals by a common distance, at most `max_mm`, to give the mesh the required volume.
/// This compensates for the volume lost by smoothing and flat cells.
void restore_volume(SimplexMesh& mesh, double volume_mm3, double max_mm) {
  double moved_mm = 0;
  for (int pass = 0; pass < 3; ++pass) {
    const SurfaceMeasures now = measure(mesh);
    const double step_mm =
        std::clamp((volume_mm3 - now.volume_mm3) / now.area_mm2, -max_mm - moved_mm, max_mm - moved_mm);
    moved_mm += step_mm;
    const SimplexMesh before = mesh;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      mesh.positions[v] += (step_mm * vertex_geometry(before, v).normal).cast<float>();
  }
}

/// Set voxels of a row (j + k * size[1]) that follow each other along i.
struct RunOfVoxels {
  std::size_t row;
  int first, end;  ///< along i; `end` is not set
};

std::vector<RunOfVoxels> set_runs(const Mask& mask) {
  const int ni = mask.geometry.size[0];
  std::vector<RunOfVoxels> runs;
  const std::size_t rows = mask.voxels.size() / static_cast<std::size_t>(ni);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint8_t* const voxels = mask.voxels.data() + row * static_cast<std::size_t>(ni);
    for (int i = 0; i < ni;) {
      const std::uint8_t* const set = std::find_if(voxels + i, voxels + ni, [](std::uint8_t v) { return v != 0; });
      const std::uint8_t* const end = std::find(set, voxels + ni, std::uint8_t{0});
      if (set != end) runs.push_back({row, static_cast<int>(set - voxels), static_cast<int>(end - voxels)});
      i = static_cast<int>(end - voxels);
    }
  }
  return runs;
}

}  // namespace

std::vector<float> smoothed_voxels(const std::vector<std::uint8_t>& set, const VoxelBox& box) {
  std::vector<float> once(set.begin(), set.end());
  smooth_gaussian(once, box, {1, 1, 1});
  std::vector<float> twice = once;
  smooth_gaussian(twice, box, {1, 1, 1});
  for (std::size_t v = 0; v < once.size(); ++v) once[v] = 2 * once[v] - twice[v];
  return once;
}

std::vector<std::vector<std::size_t>> connected_components(const Mask& mask) {
  const auto [ni, nj, nk] = mask.geometry.size;
  const std::vector<RunOfVoxels> runs = set_runs(mask);
  // Union by the earlier run, so that a root is the first run of its part.
  std::vector<std::uint32_t> root(runs.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t run) {
    while (root[run] != run) run = root[run] = root[root[run]];
    return run;
  };
  const auto join_rows = [&](std::size_t a, std::size_t a_end, std::size_t b, std::size_t b_end) {
    while (a < a_end && b < b_end) {
      // A voxel has the neighbours i and i + 1 in a row forwards.
      if (runs[b].first <= runs[a].end && runs[a].first < runs[b].end) {
        const std::uint32_t x = find(static_cast<std::uint32_t>(a)), y = find(static_cast<std::uint32_t>(b));
        root[std::max(x, y)] = std::min(x, y);
      }
      runs[a].end < runs[b].end ? ++a : ++b;
    }
  };
  std::vector<std::size_t> row_start(static_cast<std::size_t>(nj) * nk + 1, runs.size());
  for (std::size_t run = runs.size(), row = row_start.size() - 1; row-- > 0;) {
    while (run > 0 && runs[run - 1].row >= row) --run;
    row_start[row] = run;
  }
  const auto join = [&](std::size_t a, std::size_t b) {
    join_rows(row_start[a], row_start[a + 1], row_start[b], row_start[b + 1]);
  };
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j) {
      const std::size_t row = static_cast<std::size_t>(k) * nj + j;
      if (j + 1 < nj) join(row, row + 1);
      if (k + 1 < nk) join(row, row + nj);
      if (j + 1 < nj && k + 1 < nk) join(row, row + nj + 1);
    }
  std::vector<std::vector<std::size_t>> parts;
  std::vector<std::uint32_t> part_of(runs.size());
  std::vector<std::size_t> counts;
  for (std::uint32_t run = 0; run < runs.size(); ++run) {
    const std::uint32_t first = find(run);
    if (first == run) part_of[run] = static_cast<std::uint32_t>(counts.size()), counts.push_back(0);
    part_of[run] = part_of[first];
    counts[part_of[run]] += static_cast<std::size_t>(runs[run].end - runs[run].first);
  }
  parts.resize(counts.size());
  for (std::size_t part = 0; part < parts.size(); ++part) parts[part].reserve(counts[part]);
  for (std::size_t run = 0; run < runs.size(); ++run)
    for (int i = runs[run].first; i < runs[run].end; ++i)
      parts[part_of[run]].push_back(runs[run].row * static_cast<std::size_t>(ni) + static_cast<std::size_t>(i));
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return parts;
}

int fill_cavities(Mask& mask, std::size_t max_voxels) {
  const VoxelBox box = bounding_box(mask, mask);
  if (box.voxel_count() == 0) return 0;
  Mask background;  // complement of the mask in the box, extended by one layer of voxels
  background.geometry.size = {box.size[0] + 2, box.size[1] + 2, box.size[2] + 2};
  background.voxels.assign(background.geometry.voxel_count(), 1);
  const auto offset = [&size = mask.geometry.size](int i, int j, int k) {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  };
  const VoxelBox padded{{0, 0, 0}, background.geometry.size};
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i) {
        if (mask.voxels[offset(box.first[0] + i, box.first[1] + j, box.first[2] + k)])
          background.voxels[padded.offset(i + 1, j + 1, k + 1)] = 0;
      }
  int filled = 0;
  for (const std::vector<std::size_t>& part : connected_components(background)) {
    if (part.size() > max_voxels || part.front() == 0) continue;  // the component of the first voxel is the outside
    ++filled;
    const auto columns = static_cast<std::size_t>(padded.size[0]), rows = static_cast<std::size_t>(padded.size[1]);
    for (const std::size_t v : part) {
      const auto i = static_cast<int>(v % columns), j = static_cast<int>(v / columns % rows),
                 k = static_cast<int>(v / columns / rows);
      mask.voxels[offset(box.first[0] + i - 1, box.first[1] + j - 1, box.first[2] + k - 1)] = 1;
    }
  }
  return filled;
}

SimplexMesh mesh_of_mask(const Mask& mask, int vertices) {
  if (std::find(mask.voxels.begin(), mask.voxels.end(), 1) == mask.voxels.end())
    throw Error("mesh of a label", "no voxel has this label", "choose a label that occurs in the image");
  const SmoothedMask field = smoothed(mask);
  const TriangleMesh surface = iso_surface(field.values, field.box.size, 0, field.mm_from_index);
  const double edge_mm = vertices > 0 ? equilateral_edge_mm(surface, vertices)
                                      : kEdgeVoxels * std::cbrt(std::abs(field.mm_from_index.linear().determinant()));
  const SurfaceProjection project = [&](const Eigen::Vector3d& mm) {
    return project_onto_iso_surface(field.values, field.box.size, 0, field.mm_from_index, mm);
  };
  SimplexMesh mesh = remeshed_dual_of(surface, edge_mm, project);
  relax(mesh, project);
  const auto voxels = static_cast<double>(std::count(mask.voxels.begin(), mask.voxels.end(), 1));
  restore_volume(mesh, voxels * std::abs(field.mm_from_index.linear().determinant()),
                 kMaxOffset * mask.geometry.spacing_mm.minCoeff());
  validate(mesh);
  return mesh;
}

InscribedBall largest_inscribed_ball(const Mask& mask) {
  const VoxelBox box = box_around(mask);
  std::vector<std::uint8_t> outside(box.voxel_count(), 1);
  each_voxel(mask, box, [&](std::size_t at, std::uint8_t set) { outside[at] = !set; });
  const Eigen::Affine3d world = mask.geometry.world_from_index();
  const std::vector<float> distance = distance_map(outside, box, world.linear());
  const std::size_t deepest =
      static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
  SIMPLEXSEG_EXPECT(distance[deepest] > 0);
  const std::size_t ni = static_cast<std::size_t>(box.size[0]), nj = static_cast<std::size_t>(box.size[1]);
  const Eigen::Vector3i in_box(static_cast<int>(deepest % ni), static_cast<int>(deepest / ni % nj),
                               static_cast<int>(deepest / (ni * nj)));
  const Eigen::Vector3d index = (in_box + Eigen::Vector3i(box.first.data())).cast<double>();
  const double half_mm = 0.5 * mask.geometry.spacing_mm.minCoeff();  // smallest distance from a voxel centre to a face
  return {world * index, std::max(distance[deepest] - half_mm, half_mm)};
}

Topology topology_of(const SimplexMesh& mesh) {
  const int count = mesh.vertex_count();
  std::vector<bool> seen(static_cast<std::size_t>(count));
  int surfaces = 0;
  for (int start = 0; start < count; ++start) {
    if (seen[start]) continue;
    ++surfaces;
    seen[start] = true;
    std::vector<int> open{start};
    while (!open.empty()) {
      const int v = open.back();
      open.pop_back();
      for (const int n : mesh.neighbours[v])
        if (!seen[n]) seen[n] = true, open.push_back(n);
    }
  }
  // V - E + F = 2 surfaces - 2 genus, with E = 3V/2.
  const int euler = cells_of(mesh).count() - count / 2;
  return {surfaces, surfaces - euler / 2};
}

}  // namespace simplexseg
