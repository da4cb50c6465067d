// SPDX-License-Identifier: Apache-2.0
// What a kernel sees: a trivially copyable view of one memory space. Host code owns the arrays (src/gpu/step_engine.h).
#pragma once
#include <cstdint>

#include "core/parameters.h"
#include "core/vec3.h"

namespace simplexseg {

/// What the kernels know of a mesh besides its vertices.
struct MeshConstants {
  ForceParameters forces;
  int first_vertex, vertex_count;
  float dt2;             ///< squared timestep, after the stability limit
  float keep;            ///< 1 - damping
  float voxel_mm;        ///< smallest spacing of the volume: the unit "voxel" of parameters
  float edge_mm;         ///< mean edge length when the mesh was loaded
  float intensity_low, intensity_scale;   ///< (intensity - low) * scale lies in [0, 1] within its region model
  int region_table;      ///< offset of its log-likelihood ratios in StepView::region_tables, -1: none
  int finest;            ///< 0 while coarser than the level it is to end on

  /// `p` is the parameter's index in the table of force F.
  template <class F>
  SIMPLEXSEG_HD float value(typename F::Parameter p) const {
    return forces.values[static_cast<int>(F::id)][static_cast<int>(p)];
  }
  template <class F>
  SIMPLEXSEG_HD int integer(typename F::Parameter p) const {
    return static_cast<int>(value<F>(p) + 0.5f);
  }
};

/// The voxels as T, and the affine map from world (mm) to voxel index, row-major 3x4.
struct VolumeView {
  const void* voxels = nullptr;
  int size[3] = {0, 0, 0};
  float index_from_world[12] = {};
  float intensity_low = 0, intensity_scale = 1;   ///< (intensity - low) * scale lies in [0, 1] for all but outliers
};

/// One entry of an attraction patch: a vertex of the p-order neighbourhood of an attraction point.
struct PatchEntry {
  int vertex;            ///< -1: unused
  float weight;
};
struct PointView {
  Vec4 position;         ///< mm; w unused
  int mesh;
  int nearest;           ///< vertex P0 that is to reach the point; -1 before it was bound
};
/// Sums over the attraction points of a vertex in fixed point (2^-20), so that the order of adding does not matter.
struct alignas(32) AttractionSum {
  long long weight, x, y, z;
};
inline constexpr float kFixedPoint = 1048576.0f;
inline constexpr int kMaxNeighbourhoodOrder = 10;
inline constexpr int kMaxPatch = 1 + 3 * kMaxNeighbourhoodOrder * (kMaxNeighbourhoodOrder + 1) / 2 + 60;

/// The first failure of a batch of steps: step << 40 | vertex << 8 | force; ~0 when there is none.
struct StepStatus {
  unsigned long long failure;
};

struct StepView {
  int vertex_count = 0;
  int mesh_count = 0;
  int point_count = 0;
  const MeshConstants* meshes = nullptr;
  const Int4* neighbours = nullptr;        ///< x, y, z: neighbours; w: mesh
  const Vec4* previous = nullptr;          ///< positions one step ago, mm
  const Vec4* current = nullptr;           ///< positions, mm
  Vec4* next = nullptr;
  Vec4* frame = nullptr;                   ///< unit normal, elevation over area h / S (1/mm) of the current positions
  const Vec4* shape = nullptr;             ///< e1, e2, h_ref (mm), S_ref (mm^2)
  Vec4* gradient_target = nullptr;         ///< target point (mm), confidence 0..1
  Vec4* profile_target = nullptr;
  Vec4* region_target = nullptr;
  const float* profiles = nullptr;         ///< reference profiles, 2 * half length + 1 values a vertex
  int profile_stride = 0;
  const float* region_tables = nullptr;    ///< kRegionBins log-likelihood ratios a mesh, each in [-1, 1]
  Vec4* local_statistics = nullptr;        ///< mean inside, mean outside, mean squared deviation, weight
  PointView* points = nullptr;
  unsigned long long* nearest = nullptr;   ///< of each point: squared distance bits << 32 | vertex
  PatchEntry* patches = nullptr;           ///< kMaxPatch a point
  AttractionSum* attraction = nullptr;
  VolumeView volume;
  StepStatus* status = nullptr;
};

}  // namespace simplexseg
