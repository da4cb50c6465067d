// SPDX-License-Identifier: Apache-2.0
#include "image/label_surface.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/expect.h"
#include "mesh/iso_surface.h"
#include "mesh/mesh_geometry.h"
#include "mesh/remesh.h"

namespace simplexseg {
namespace {

constexpr int kReach = 3;            // of the Gaussian, in voxels
constexpr float kLeastOver = 0.12f;  // from the middle: how far a voxel stays on its side (a flat face has 0.19)
constexpr double kEdgeVoxels = 1.25;
constexpr int kPasses = 10;  // of relaxation, each by
constexpr double kShare = 0.5;
constexpr double kMostMoved = 0.3;  // of a voxel, to keep the volume

/// The voxels of a box around the mask, wide enough for the smoothing.
struct BoxField {
  VoxelBox box;
  std::vector<float> values;  ///< above 0 inside
  Eigen::Affine3d mm_from_index;
};

VoxelBox box_around(const Mask& mask) {
  VoxelBox box = bounding_box(mask, mask);
  for (int a = 0; a < 3; ++a) box.first[a] -= kReach, box.size[a] += 2 * kReach;
  return box;
}

/// Calls f(index within the box, value) for each voxel of the mask in the box.
template <class F>
void each_voxel(const Mask& mask, const VoxelBox& box, F&& f) {
  const auto [ni, nj, nk] = mask.geometry.size;
  for (int k = std::max(0, -box.first[2]); k < std::min(box.size[2], nk - box.first[2]); ++k)
    for (int j = std::max(0, -box.first[1]); j < std::min(box.size[1], nj - box.first[1]); ++j)
      for (int i = std::max(0, -box.first[0]); i < std::min(box.size[0], ni - box.first[0]); ++i)
        f(box.offset(i, j, k),
          mask.voxels[(static_cast<std::size_t>(k + box.first[2]) * nj + j + box.first[1]) * ni + i + box.first[0]]);
}

/// One pass of a separable Gaussian with a deviation of one voxel; beyond the box there is nothing.
void smooth_along(std::vector<float>& values, const VoxelBox& box, int axis) {
  std::array<float, kReach + 1> weight;
  float sum = 0;
  for (int r = 0; r <= kReach; ++r) sum += (r ? 2 : 1) * (weight[r] = std::exp(-0.5f * static_cast<float>(r * r)));
  for (float& w : weight) w /= sum;
  const std::size_t stride = axis == 0   ? 1
                             : axis == 1 ? static_cast<std::size_t>(box.size[0])
                                         : static_cast<std::size_t>(box.size[0]) * box.size[1];
  const int length = box.size[axis];
  std::vector<float> line(static_cast<std::size_t>(length) + 2 * kReach);
  const std::size_t lines = box.voxel_count() / static_cast<std::size_t>(length);
  for (std::size_t n = 0; n < lines; ++n) {
    float* const first = values.data() + n / stride * stride * static_cast<std::size_t>(length) + n % stride;
    for (int i = 0; i < length; ++i) line[i + kReach] = first[i * stride];
    for (int i = 0; i < length; ++i) {
      float value = weight[0] * line[i + kReach];
      for (int r = 1; r <= kReach; ++r) value += weight[r] * (line[i + kReach - r] + line[i + kReach + r]);
      first[i * stride] = value;
    }
  }
}

BoxField smoothed(const Mask& mask) {
  BoxField field;
  field.box = box_around(mask);
  std::vector<std::uint8_t> inside(field.box.voxel_count());
  each_voxel(mask, field.box, [&](std::size_t at, std::uint8_t set) { inside[at] = set; });
  field.values = smoothed_voxels(inside, field.box);
  for (std::size_t v = 0; v < inside.size(); ++v) {
    const float over = field.values[v] - 0.5f;
    field.values[v] = inside[v] ? std::max(over, kLeastOver) : std::min(over, -kLeastOver);
  }
  field.mm_from_index = mask.geometry.world_from_index();
  field.mm_from_index.translate(Eigen::Vector3i(field.box.first.data()).cast<double>());
  return field;
}

/// Draws each vertex to the middle of its neighbours within its tangent plane: where they lie in a line, or turn round,
/// shape memory has nothing to hold on to.
void relax(SimplexMesh& mesh, const OntoSurface& onto) {
  for (int pass = 0; pass < kPasses; ++pass) {
    const SimplexMesh before = mesh;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3d at = before.positions[v].cast<double>(), normal = vertex_geometry(before, v).normal;
      Eigen::Vector3d way = -at;
      for (const int n : before.neighbours[v]) way += before.positions[n].cast<double>() / 3;
      way -= way.dot(normal) * normal;
      mesh.positions[v] = onto(at + kShare * way).cast<float>();
    }
  }
}

/// Moves all vertices as far along their normals, `most_mm` at most, until the mesh has the volume: smoothing and flat
/// cells have cost some.
void give_volume(SimplexMesh& mesh, double volume_mm3, double most_mm) {
  double moved_mm = 0;
  for (int pass = 0; pass < 3; ++pass) {
    const SurfaceMeasures now = measure(mesh);
    const double way_mm =
        std::clamp((volume_mm3 - now.volume_mm3) / now.area_mm2, -most_mm - moved_mm, most_mm - moved_mm);
    moved_mm += way_mm;
    const SimplexMesh before = mesh;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      mesh.positions[v] += (way_mm * vertex_geometry(before, v).normal).cast<float>();
  }
}

/// Neighbours by the edges of the tetrahedra of iso_surface(): one step along any set of axes, all forwards or all
/// backwards.
constexpr int kSteps[14][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 0},   {0, 1, 1},   {1, 0, 1},   {1, 1, 1},
                               {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-1, -1, 0}, {0, -1, -1}, {-1, 0, -1}, {-1, -1, -1}};

}  // namespace

std::vector<float> smoothed_voxels(const std::vector<std::uint8_t>& set, const VoxelBox& box) {
  std::vector<float> once(set.begin(), set.end());
  for (int axis = 0; axis < 3; ++axis) smooth_along(once, box, axis);
  std::vector<float> twice = once;
  for (int axis = 0; axis < 3; ++axis) smooth_along(twice, box, axis);
  for (std::size_t v = 0; v < once.size(); ++v) once[v] = 2 * once[v] - twice[v];
  return once;
}

std::vector<std::vector<std::size_t>> parts_of(const Mask& mask) {
  const auto& size = mask.geometry.size;
  std::vector<std::uint8_t> left = mask.voxels;
  std::vector<std::vector<std::size_t>> parts;
  for (std::size_t start = 0; start < left.size(); ++start) {
    if (!left[start]) continue;
    std::vector<std::size_t>& part = parts.emplace_back(1, start);
    left[start] = 0;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::size_t row = part[next] / static_cast<std::size_t>(size[0]);
      const int at[3] = {static_cast<int>(part[next] % static_cast<std::size_t>(size[0])),
                         static_cast<int>(row % static_cast<std::size_t>(size[1])),
                         static_cast<int>(row / static_cast<std::size_t>(size[1]))};
      for (const auto& step : kSteps) {
        const int to[3] = {at[0] + step[0], at[1] + step[1], at[2] + step[2]};
        bool within = true;
        for (int a = 0; a < 3; ++a) within = within && to[a] >= 0 && to[a] < size[a];
        const std::size_t v = (static_cast<std::size_t>(to[2]) * size[1] + to[1]) * size[0] + to[0];
        if (within && left[v]) left[v] = 0, part.push_back(v);
      }
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return parts;
}

int fill_cavities(Mask& mask, std::size_t most) {
  const VoxelBox box = bounding_box(mask, mask);
  if (box.voxel_count() == 0) return 0;
  Mask around;  // what is not set, with a layer of outside around the box
  around.geometry.size = {box.size[0] + 2, box.size[1] + 2, box.size[2] + 2};
  around.voxels.assign(around.geometry.voxel_count(), 1);
  const auto place = [&size = mask.geometry.size](int i, int j, int k) {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  };
  const VoxelBox padded{{0, 0, 0}, around.geometry.size};
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i) {
        if (mask.voxels[place(box.first[0] + i, box.first[1] + j, box.first[2] + k)])
          around.voxels[padded.offset(i + 1, j + 1, k + 1)] = 0;
      }
  int filled = 0;
  for (const std::vector<std::size_t>& part : parts_of(around)) {
    if (part.size() > most || part.front() == 0) continue;  // the outside begins at the first voxel
    ++filled;
    const auto columns = static_cast<std::size_t>(padded.size[0]), rows = static_cast<std::size_t>(padded.size[1]);
    for (const std::size_t v : part) {
      const auto i = static_cast<int>(v % columns), j = static_cast<int>(v / columns % rows),
                 k = static_cast<int>(v / columns / rows);
      mask.voxels[place(box.first[0] + i - 1, box.first[1] + j - 1, box.first[2] + k - 1)] = 1;
    }
  }
  return filled;
}

SimplexMesh mesh_of_mask(const Mask& mask, int vertices) {
  if (std::find(mask.voxels.begin(), mask.voxels.end(), 1) == mask.voxels.end())
    throw Error("mesh of a label", "no voxel has it", "give a label that there is");
  const BoxField field = smoothed(mask);
  const TriangleMesh surface = iso_surface(field.values, field.box.size, 0, field.mm_from_index);
  const double edge_mm = vertices > 0 ? even_edge_mm(surface, vertices)
                                      : kEdgeVoxels * std::cbrt(std::abs(field.mm_from_index.linear().determinant()));
  const OntoSurface onto = [&](const Eigen::Vector3d& mm) {
    return onto_iso_surface(field.values, field.box.size, 0, field.mm_from_index, mm);
  };
  SimplexMesh mesh = even_dual_of(surface, edge_mm, onto);
  relax(mesh, onto);
  const auto voxels = static_cast<double>(std::count(mask.voxels.begin(), mask.voxels.end(), 1));
  give_volume(mesh, voxels * std::abs(field.mm_from_index.linear().determinant()),
              kMostMoved * mask.geometry.spacing_mm.minCoeff());
  validate(mesh);
  return mesh;
}

InnerBall inner_ball(const Mask& mask) {
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
  const double half_mm = 0.5 * mask.geometry.spacing_mm.minCoeff();  // the nearest voxel outside begins so far before
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
