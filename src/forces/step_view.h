// SPDX-License-Identifier: Apache-2.0
// What a kernel sees: a trivially copyable view of one memory space. Host code owns the arrays (src/gpu/step_engine.h).
#pragma once
#include <cstdint>
#include <type_traits>

#include "core/vec3.h"
#include "forces/parameters.h"
#include "forces/step_form.h"

namespace simplexseg {

// What a kernel is called with, `i`, is one vertex, an int; or on the CPU eight in a row (forces/eight.h), of which it
// then reads, works out and writes eight values where it has one. It says so with these:

/// A number of vertex or vertices I.
template <class I>
struct RealOf {
  using Type = float;
};
template <class I>
using Real = typename RealOf<I>::Type;
SIMPLEXSEG_HD Vec4 load(const Vec4* texels, int i) { return texels[i]; }
SIMPLEXSEG_HD float load_w(const Vec4* texels, int i) { return texels[i].w; }
SIMPLEXSEG_HD void store(Vec4* texels, int i, Vec4 x) { texels[i] = x; }
SIMPLEXSEG_HD float load(const float* values, int i) { return values[i]; }
SIMPLEXSEG_HD float look_up(const float* values, int i) { return values[i]; }
SIMPLEXSEG_HD void store(float* values, int i, float x) { values[i] = x; }
SIMPLEXSEG_HD void store_w(Vec4* texels, int i, float w) { texels[i].w = w; }
/// f(vertex, its lane) for each vertex of i; what is not uniform is taken apart before.
template <class F>
SIMPLEXSEG_HD void each(int i, F&& f) {
  f(i, 0);
}
/// One value, taken apart: of the only lane.
template <class T>
struct Alone {
  T value;
  SIMPLEXSEG_HD const T& operator[](int) const { return value; }
};
SIMPLEXSEG_HD Alone<Vec3> one_by_one(Vec3 x) { return {x}; }
SIMPLEXSEG_HD bool is_set(bool x, int) { return x; }

/// Texels that kernels only read. On a device either cached loads of global memory (the default: faster, see
/// docs/adr/0008-textures.md) or a texture object over the same memory: -DSIMPLEXSEG_TEXTURE_ARRAYS=ON.
template <class T>
struct Texels {
  const T* data = nullptr;
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
  unsigned long long texture = 0;  ///< cudaTextureObject_t, 1D over linear memory
#endif
  SIMPLEXSEG_HD T operator[](int i) const {
#if !defined(__CUDA_ARCH__)
    return data[i];
#else
    static_assert(sizeof(T) == sizeof(float4));
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
    const float4 x = tex1Dfetch<float4>(texture, i);
#else
    const float4 x = reinterpret_cast<const float4*>(data)[i];  // of a block's own memory, too (src/gpu/tiles.h)
#endif
    return {x.x, x.y, x.z, x.w};
#endif
  }
  /// Those of several vertices (forces/eight.h).
  template <class I>
  requires(!std::is_integral_v<I>) SIMPLEXSEG_HD auto operator[](I i) const { return load(data, i); }
  /// The fourth value alone.
  template <class I>
  requires(!std::is_integral_v<I>) SIMPLEXSEG_HD auto w(I i) const { return load_w(data, i); }
  SIMPLEXSEG_HD float w(int i) const {
#if !defined(__CUDA_ARCH__)
    return data[i].w;
#elif defined(SIMPLEXSEG_TEXTURE_ARRAYS)
    return tex1Dfetch<float4>(texture, i).w;
#else
    return data[i].w;
#endif
  }
};

/// Differences of three neighbours from their vertex, and the mesh.
struct alignas(8) PackedNeighbours {
  std::int16_t x, y, z;
  std::uint16_t mesh;
};
/// Neighbours (x, y, z) and mesh (w) of each vertex, which never change: on a device packed into 8 bytes where
/// neighbours lie near each other (differences of 16 bits), else 16 bytes, by cached loads; or with
/// SIMPLEXSEG_TEXTURE_ARRAYS a 2D texture over a CUDA array, kWidth texels a row.
struct NeighbourTexels {
  static constexpr int kWidth = 4096;
  const Int4* data = nullptr;
  const PackedNeighbours* packed = nullptr;  ///< used where it is not null
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
  unsigned long long texture = 0;
#endif
  template <class I>
  requires(!std::is_integral_v<I>) SIMPLEXSEG_HD auto operator[](I i) const { return load(data, i); }
  SIMPLEXSEG_HD Int4 operator[](int i) const {
#if !defined(__CUDA_ARCH__)
    return data[i];
#elif defined(SIMPLEXSEG_TEXTURE_ARRAYS)
    const int4 x = tex2D<int4>(texture, i % kWidth, i / kWidth);
    return {x.x, x.y, x.z, x.w};
#else
    if (packed != nullptr) {
      const uint2 x = __ldg(reinterpret_cast<const uint2*>(packed) + i);
      return {i + static_cast<short>(x.x & 0xffffu), i + static_cast<short>(x.x >> 16),
              i + static_cast<short>(x.y & 0xffffu), static_cast<int>(x.y >> 16)};
    }
    const int4 x = __ldg(reinterpret_cast<const int4*>(data) + i);
    return {x.x, x.y, x.z, x.w};
#endif
  }
};

/// Where the field P(object) of a mesh lies: a box of voxels of the volume, i fastest. Values of kFieldFloor to
/// kFieldScale are P in units of 1 / kFieldScale; below kFieldFloor P is about 0, and the value falls by kFieldFall for
/// each voxel of the least spacing that lies between the voxel and the object, so that the way back is known
/// everywhere.
struct FieldBox {
  long long offset = -1;  ///< in StepView::fields; -1: there is none
  int first[3] = {0, 0, 0}, size[3] = {0, 0, 0};
  SIMPLEXSEG_HD Vec3 first_voxel() const {
    return {static_cast<float>(first[0]), static_cast<float>(first[1]), static_cast<float>(first[2])};
  }
};
inline constexpr float kFieldScale = 65535, kFieldFloor = 2048, kFieldFall = 16;

/// What the kernels know of a mesh besides its vertices.
struct MeshConstants {
  ForceParameters forces;
  int first_vertex, vertex_count;
  int rests;  ///< not 0: no force acts and nothing moves, so that kernels may leave its vertices out
  StepForm form;
  float stiffness;  ///< bound of the internal forces
  float model;      ///< k of the multigrid model: half of that
  float support;    ///< of every vertex in that model, as a share of k, besides that of its forces
  int root;         ///< the vertex of the coarsest level that stands for the whole mesh, -1: there are no levels
  float limit_mm;   ///< a vertex with a coordinate beyond it has left the scene
  int strongest;    ///< the force of the largest bound, to be named where nothing better is known
  float voxel_mm;   ///< smallest spacing of the volume: the unit "voxel" of parameters
  float edge_mm;    ///< mean edge length when the mesh was made or refined
  float intensity_low, intensity_scale;  ///< (intensity - low) * scale lies in [0, 1] within its region model
  int region_table;                      ///< offset of its log-likelihood ratios in StepView::region_tables, -1: none
  FieldBox field;
  int finest;                    ///< 0 while coarser than the level it is to end on
  int first_point, point_count;  ///< its attraction points

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

/// The voxels and the affine map from world (mm) to voxel index, row-major 3x4. A device holds them as a 3D texture
/// where its texture unit can filter their type, else in linear memory (src/forces/sampling.h).
struct VolumeView {
  const void* voxels = nullptr;                  ///< linear, i fastest
  unsigned long long filtered = 0, fetched = 0;  ///< cudaTextureObject_t: trilinear, nearest
  float texel_scale = 1;                         ///< intensity = texel * texel_scale
  int size[3] = {0, 0, 0};
  float index_from_world[12] = {};
  float intensity_low = 0, intensity_scale = 1;  ///< (intensity - low) * scale lies in [0, 1] for all but outliers
};

/// One entry of an attraction patch: a vertex of the p-order neighbourhood of an attraction point.
struct PatchEntry {
  int vertex;  ///< -1: unused
  float weight;
};
struct PointView {
  Vec4 position;  ///< mm; w unused
  int mesh;
  int nearest;      ///< vertex P0 that is to reach the point; -1 before it was bound
  int order;        ///< of the neighbourhood that was found for it
  int patch_count;  ///< entries of it
};
/// Sums over the attraction points of a vertex in fixed point (2^-28), so that the order of adding does not matter.
struct alignas(32) AttractionSum {
  long long weight, x, y, z;
};
inline constexpr float kFixedPoint = 268435456.0f;
inline constexpr int kMaxNeighbourhoodOrder = 10;
inline constexpr int kMaxPatch = 1 + 3 * kMaxNeighbourhoodOrder * (kMaxNeighbourhoodOrder + 1) / 2 + 60;

/// Steps of a recording, of so many that are left: 30 at most, a multiple of 3, of 2 and of 5. Few lengths, that few
/// runs are recorded; one alone is always the last (OfRun).
constexpr int length_of_run(int left) {
  for (int length : {30, 10, 5, 2})
    if (left >= length) return length;
  return left;
}

/// Vertices and points that one call of FindNearest compares.
inline constexpr int kNearestBlock = 128, kPointGroup = 8;

/// How a batch of steps went. The first failure: step << 40 | vertex << 8 | force; ~0 when there is none. Steps are
/// counted from the batch's start: a run that is replayed knows only its own.
struct StepStatus {
  unsigned long long failure = ~0ull;
  unsigned long long first = 0;     ///< step of the batch at which the present run starts
  unsigned long long next_run = 0;  ///< ... and the one after it
};
/// What is measured at the end of a batch.
struct MeshMotion {
  float mean_move_mm;  ///< of the last step
  float mean_edge_mm;
  float mean_square_force;  ///< of |sum_f k_f d_f|^2 in the last step, mm^2
  float change,
      square_move;  ///< means of -m.(z - z') and |m|^2, m the move before the last step, z and z' after and before it
  float folded;     ///< vertices whose normal opposes a neighbour's
  float volume;     ///< mean of (P - P_first) . N, which has the sign of the volume enclosed
  float support;    ///< with a multigrid correction: stiffness of image and attraction a vertex, where it is least
};

/// A vertex of a level coarser than its mesh. Those of all levels lie in one row after another, from fine to coarse, so
/// that the next one has the ends of what this one has the beginnings of.
struct CoarseRow {
  int first_part, first_edge;
  float degree;  ///< sum of the conductances
  int mesh;
};
struct CoarseEdge {
  int to;
  float conductance;
};
/// The levels of the multigrid correction (src/gpu/multigrid.h). Vertices are counted over all levels, the mesh's own
/// first.
struct LevelsView {
  const CoarseRow* rows = nullptr;  ///< from the first coarse vertex on
  const int* parts = nullptr;
  const CoarseEdge* edges = nullptr;
  const int* coarse_of = nullptr;
  Vec4* residual = nullptr;     ///< right-hand side
  Vec4* correction = nullptr;   ///< after the first Jacobi step
  Vec4* relaxed = nullptr;      ///< at the end of the level
  Vec4* stiffness_a = nullptr;  ///< E: xx, xy, xz, yy
  Vec4* stiffness_b = nullptr;  ///< yz, zz
};

/// The attraction points of all meshes and what was found for them (src/forces/attraction.h).
struct AttractionView {
  PointView* points = nullptr;
  int count = 0;                          ///< of the points
  int groups = 0;                         ///< groups of kPointGroup points of the mesh that has most
  int nearest_blocks = 0;                 ///< blocks of kNearestBlock vertices of the largest mesh
  unsigned long long* nearest = nullptr;  ///< nearest_blocks a point: squared distance bits << 32 | vertex
  PatchEntry* patches = nullptr;          ///< kMaxPatch a point
  AttractionSum* sums = nullptr;          ///< zero but for vertices that a point pulls in this step
  std::uint8_t* in_patch = nullptr;       ///< 1 for vertices in some patch
};
struct StepView {
  int vertex_count = 0;
  int first_vertex = 0;  ///< of all meshes' vertices, the one that vertex 0 is here
  int mesh_count = 0;
  const MeshConstants* meshes = nullptr;
  NeighbourTexels neighbours;  ///< x, y, z: neighbours; w: mesh
  Texels<Vec4> previous;       ///< positions one step ago, mm
  Texels<Vec4> current;        ///< positions, mm
  Vec4* next = nullptr;
  Vec4* oldest = nullptr;      ///< the memory of `previous`, whose w is free once a step has read it
  Texels<Vec4> frame;          ///< unit normal, elevation over area h / S (1/mm) of the current positions
  Vec4* new_frame = nullptr;   ///< the same array, for the kernel that writes it
  float* ring_sums = nullptr;  ///< of the neighbours' elevation over area, 1/mm; nullptr: read one by one, on a device
  Texels<Vec4> shape;          ///< e1, e2, h_ref (mm), S_ref (mm^2)
  /// For each force that finds targets, the point (mm) to which it draws each vertex, and its confidence: in [0, 1],
  /// or as far as the force's stability bound allows.
  Vec4* targets[kForceCount] = {};
  const float* profiles = nullptr;  ///< reference profiles, 2 * half length + 1 values a vertex
  int profile_stride = 0;
  const float* region_tables = nullptr;   ///< kRegionBins log-likelihood ratios a mesh, each in [-1, 1]
  const std::uint16_t* fields = nullptr;  ///< P(object) of all meshes that have a field, one box after another
  Vec4* local_statistics = nullptr;       ///< mean inside, mean outside, mean squared deviation, weight
  AttractionView attraction;
  LevelsView levels;
  const StepCoefficients* coefficients = nullptr;  ///< of each mesh
  VolumeView volume;
  StepStatus* status = nullptr;

  template <class F>
  SIMPLEXSEG_HD Vec4* targets_of() const {
    return targets[static_cast<int>(F::id)];
  }
};

}  // namespace simplexseg
