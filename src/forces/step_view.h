// SPDX-License-Identifier: Apache-2.0
// Kernel arguments: trivially copyable views of arrays in one memory space (host or device). Host code owns the arrays
// (src/gpu/step_engine.h).
#pragma once
#include <cstdint>
#include <type_traits>

#include "core/vec3.h"
#include "forces/parameters.h"
#include "forces/step_form.h"

namespace simplexseg {

// The index `i` of a kernel is one vertex (an int) or, on the CPU, eight consecutive vertices (an Eight from
// forces/eight.h). With the following types and functions, the same kernel reads, computes and writes one value or
// eight.

/// Type of a real value for each vertex of an index of type I.
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
SIMPLEXSEG_HD float gather(const float* values, int i) { return values[i]; }
SIMPLEXSEG_HD void store(float* values, int i, float x) { values[i] = x; }
SIMPLEXSEG_HD void store_w(Vec4* texels, int i, float w) { texels[i].w = w; }
/// Calls f(vertex, lane) for each vertex of i. Lane values that f uses must be unpacked first (unpack_lanes()).
template <class F>
SIMPLEXSEG_HD void each(int i, F&& f) {
  f(i, 0);
}
/// Unpacked value of a single lane.
template <class T>
struct SingleLane {
  T value;
  SIMPLEXSEG_HD const T& operator[](int) const { return value; }
};
SIMPLEXSEG_HD SingleLane<Vec3> unpack_lanes(Vec3 x) { return {x}; }
SIMPLEXSEG_HD bool is_set(bool x, int) { return x; }

/// Read-only texels. On a device they are read by cached loads of global memory (the default, which is faster:
/// docs/adr/0008-textures.md) or through a texture object over the same memory (-DSIMPLEXSEG_TEXTURE_ARRAYS=ON).
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
    const float4 x = reinterpret_cast<const float4*>(data)[i];  // also used for shared memory (src/gpu/tiles.h)
#endif
    return {x.x, x.y, x.z, x.w};
#endif
  }
  /// Texels of several vertices at once (forces/eight.h).
  template <class I>
  requires(!std::is_integral_v<I>) SIMPLEXSEG_HD auto operator[](I i) const { return load(data, i); }
  /// Fourth component of a texel.
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

/// Neighbours of a vertex, as differences of their indices from its own, and the index of the mesh.
struct alignas(8) PackedNeighbours {
  std::int16_t x, y, z;
  std::uint16_t mesh;
};
/// Neighbours (x, y, z) and mesh (w) of each vertex, constant during a run. On a device they are read by cached loads,
/// of 8 bytes if all index differences and mesh indices fit into 16 bits, else of 16 bytes. With
/// SIMPLEXSEG_TEXTURE_ARRAYS they are a 2D texture over a CUDA array with kWidth texels per row.
struct NeighbourTexels {
  static constexpr int kWidth = 4096;
  const Int4* data = nullptr;
  const PackedNeighbours* packed = nullptr;  ///< packed neighbours, used if not null
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

/// Location of a mesh's foreground probability field: a box of cells of the volume (image/cell_grid.h), i fastest.
/// Values from kFieldFloor to kFieldScale are the probability P in units of 1 / kFieldScale. Below kFieldFloor P is
/// about 0, and the value encodes the distance to the object: it is lower by kFieldFall for each smallest cell spacing
/// of distance.
struct FieldBox {
  const std::uint16_t* values = nullptr;  ///< null: no field
  int size[3] = {0, 0, 0};
  float scale[3] = {1, 1, 1}, shift[3] = {0, 0, 0};  ///< index of a cell in the box: scale * index of a voxel + shift
  float cell_mm = 0;                                 ///< smallest cell spacing
  /// Index in the box at a voxel index of the volume, and difference of indices in the box from one of voxel indices.
  template <class R>
  SIMPLEXSEG_HD Vec3Of<R> index(Vec3Of<R> at) const {
    return {scale[0] * at.x + shift[0], scale[1] * at.y + shift[1], scale[2] * at.z + shift[2]};
  }
  template <class R>
  SIMPLEXSEG_HD Vec3Of<R> difference(Vec3Of<R> d) const {
    return {scale[0] * d.x, scale[1] * d.y, scale[2] * d.z};
  }
};
inline constexpr float kFieldScale = 65535, kFieldFloor = 2048, kFieldFall = 16;

/// Range of the relative area of a vertex: its area divided by that of a vertex of a regular lattice with the mean edge
/// length of the mesh, kLatticeArea * edge^2. The limits bound the masses of needle-shaped and very large cells.
inline constexpr float kMinRelativeArea = 0.25f, kMaxRelativeArea = 4, kLatticeArea = 1.2990381f;  // 3 sqrt(3) / 4

/// Constants of a mesh, read by the kernels.
struct MeshConstants {
  ForceParameters forces;
  int first_vertex, vertex_count;
  int asleep;  ///< not 0: the vertices do not move, and all positions are equal; kernels may skip them
  StepForm form;
  float stiffness;       ///< stability bound of the internal forces, including their weights
  float model;           ///< k of the multigrid model: half of `stiffness`, at least 0.1 times the other bounds
  float regularisation;  ///< diagonal regularisation of that model, as a share of k
  int root;              ///< vertex of the coarsest level that represents the whole mesh; -1: no levels
  float limit_mm;        ///< a vertex with a larger absolute coordinate has left the scene
  int strongest;         ///< force with the largest weight, reported as the default cause of a failure
  float voxel_mm;        ///< smallest spacing of the volume, the unit "voxel" of parameters
  float edge_mm;         ///< mean edge length at the creation or last refinement of the mesh
  float area_in_mass, area_in_force;     ///< SimulationParameters
  float intensity_low, intensity_scale;  ///< (intensity - low) * scale lies in [0, 1] in the region model
  int region_table;                      ///< offset of the log-likelihood ratios in StepView::region_tables; -1: none
  FieldBox field;
  int finest;                    ///< 0 while the mesh will be refined further
  int first_point, point_count;  ///< range of the mesh's attraction points

  /// Relative area of a vertex with this area (mm^2).
  template <class R>
  SIMPLEXSEG_HD R relative_area(R area) const {
    return smaller(larger((1.0f / (kLatticeArea * edge_mm * edge_mm)) * area, R(kMinRelativeArea)),
                   R(kMaxRelativeArea));
  }
  /// Value of parameter `p` of force F.
  template <class F>
  SIMPLEXSEG_HD float value(typename F::Parameter p) const {
    return forces.values[static_cast<int>(F::id)][static_cast<int>(p)];
  }
  template <class F>
  SIMPLEXSEG_HD int integer(typename F::Parameter p) const {
    return static_cast<int>(value<F>(p) + 0.5f);
  }
};

/// Voxels and the affine map from world (mm) to voxel index, a row-major 3x4 matrix. On a device the voxels are a 3D
/// texture if the texture unit can filter their type, else linear memory (src/forces/sampling.h).
struct VolumeView {
  const void* voxels = nullptr;                  ///< voxels in linear memory, i fastest
  unsigned long long filtered = 0, fetched = 0;  ///< cudaTextureObject_t: trilinear filtering, no filtering
  float texel_scale = 1;                         ///< intensity = texel * texel_scale
  int size[3] = {0, 0, 0};
  float index_from_world[12] = {};
  float intensity_low = 0, intensity_scale = 1;  ///< (intensity - low) * scale lies in [0, 1] for all but outliers
};

/// Entry of an attraction patch: a vertex in the p-order neighbourhood of an attraction point.
struct PatchEntry {
  int vertex;  ///< index of the vertex; -1: unused entry
  float weight;
};
struct PointView {
  Vec4 position;  ///< mm; w unused
  int mesh;
  int nearest;      ///< nearest vertex P0; -1 before the first binding
  int order;        ///< order of the current patch
  int patch_count;  ///< number of entries of the current patch
};
/// Sums at a vertex over the points that attract it, in fixed point (units of 2^-28; x, y, z: mm), so that they are
/// independent of the order of the additions.
struct alignas(32) AttractionSum {
  long long weight, x, y, z;
};
inline constexpr float kFixedPoint = 268435456.0f;  ///< fixed-point units per 1: 2^28
inline constexpr int kMaxNeighbourhoodOrder = 10;
/// Capacity of a patch: size of the neighbourhood of the largest order on a hexagonal lattice, plus a margin.
inline constexpr int kMaxPatch = 1 + 3 * kMaxNeighbourhoodOrder * (kMaxNeighbourhoodOrder + 1) / 2 + 60;

/// Number of steps of the next recorded run if `remaining` steps remain: 30 (a multiple of 2, 3 and 5), 10, 5, 2 or 1.
/// With few different lengths, few runs have to be recorded. Only the last run of a batch has one step, as StepInRun
/// (src/gpu/kernels.h) requires.
constexpr int run_length(int remaining) {
  for (int length : {30, 10, 5, 2})
    if (remaining >= length) return length;
  return remaining;
}

/// Largest number of vertices and of points that one call of FindNearest compares.
inline constexpr int kNearestBlock = 128, kPointGroup = 8;

/// Result of a batch of steps.
struct StepStatus {
  unsigned long long failure = ~0ull;  ///< first failure: step in the batch << 40 | vertex << 8 | force; ~0: none
  unsigned long long first = 0;        ///< first step of the current run in the batch; read by replayed runs
  unsigned long long next_run = 0;     ///< first step of the next run
};
/// Measurements of a mesh at the end of a batch.
struct MeshMotion {
  float mean_move_mm;  ///< mean length of the last move of the vertices
  float mean_edge_mm;
  float mean_square_force;  ///< mean of |sum_f k_f d_f|^2 in the last step, mm^2
  float change;       ///< mean of -m.(z - z'), mm^2; m: second-to-last move, z' and z: updates before and after it
  float square_move;  ///< mean of |m|^2, mm^2
  float folded;       ///< number of vertices whose normal is opposed to that of a neighbour
  float volume;       ///< mean of (P - P_first) . N, mm^3, which has the sign of the enclosed volume
  float external_stiffness;  ///< multigrid only: mean stiffness of image and attraction forces in the softest direction
};

/// Vertex of a coarse level. The vertices of all levels are contiguous, from fine to coarse. The ranges of parts and
/// edges end where those of the next row begin.
struct CoarseRow {
  int first_part, first_edge;
  float degree;  ///< sum of the conductances of the edges
  int mesh;
};
struct CoarseEdge {
  int to;
  float conductance;
};
/// Levels of the multigrid correction (src/gpu/multigrid.h). Vertices are numbered over all levels, starting with those
/// of the meshes.
struct LevelsView {
  const CoarseRow* rows = nullptr;  ///< rows of the coarse vertices, then an end row
  const int* parts = nullptr;       ///< vertices of the finer level, grouped by the coarse vertex they belong to
  const CoarseEdge* edges = nullptr;
  const int* coarse_of = nullptr;  ///< for each vertex, its vertex on the next coarser level
  Vec4* residual = nullptr;        ///< right-hand side
  Vec4* correction = nullptr;      ///< correction after the first Jacobi step
  Vec4* relaxed = nullptr;         ///< correction after the last smoothing step of the level
  Vec4* stiffness_a = nullptr;     ///< stiffness E: xx, xy, xz, yy
  Vec4* stiffness_b = nullptr;     ///< stiffness E: yz, zz
};

/// Attraction points of all meshes, their nearest vertices and patches (src/forces/attraction.h).
struct AttractionView {
  PointView* points = nullptr;
  int count = 0;                          ///< number of points
  int groups = 0;                         ///< number of groups of kPointGroup points in the mesh with the most points
  int nearest_blocks = 0;                 ///< number of blocks of kNearestBlock vertices in the largest mesh
  unsigned long long* nearest = nullptr;  ///< nearest_blocks per point: bits of the squared distance << 32 | vertex
  PatchEntry* patches = nullptr;          ///< kMaxPatch entries per point
  AttractionSum* sums = nullptr;          ///< one per vertex; 0 except for vertices pulled in this step
  std::uint8_t* in_patch = nullptr;       ///< 1 for vertices in at least one patch, else 0
};
/// Views of all arrays of a step.
struct StepView {
  int vertex_count = 0;
  int first_vertex = 0;  ///< index of vertex 0 of this view among the vertices of all meshes
  int mesh_count = 0;
  unsigned forces_in_use = 0;  ///< set of the forces that act on some mesh, a bit for each ForceId
  const MeshConstants* meshes = nullptr;
  NeighbourTexels neighbours;  ///< x, y, z: neighbours; w: mesh
  Texels<Vec4> previous;       ///< positions one step ago, mm
  Texels<Vec4> current;        ///< positions, mm
  Vec4* next = nullptr;
  Vec4* oldest = nullptr;      ///< writable alias of `previous`, for the w that the last step of a batch stores
  Texels<Vec4> frame;          ///< unit normal, elevation over area h / S (1/mm) of the current positions
  Vec4* new_frame = nullptr;   ///< frames that the geometry kernel writes
  float* ring_sums = nullptr;  ///< sum of the three neighbours' h / S (1/mm) for each vertex; nullptr on a device
  float* areas = nullptr;      ///< area of each vertex, mm^2: of the triangle of its neighbours; nullptr: not used
  float* masses = nullptr;     ///< mass of each vertex; nullptr: unit masses
  Texels<Vec4> shape;          ///< reference of the shape memory force: e1, e2, h_ref (mm), S_ref (mm^2)
  /// Targets of each force that has targets: position (mm) and confidence per vertex. The confidence is at least 0 and
  /// at most the stability bound of the force.
  Vec4* targets[kForceCount] = {};
  const float* profiles = nullptr;  ///< reference profiles, 2 * half length + 1 values per vertex
  int profile_stride = 0;
  const float* region_tables = nullptr;  ///< kRegionBins log-likelihood ratios per region model, in [-1, 1]
  Vec4* local_statistics = nullptr;      ///< mean inside, mean outside and variance of nearby intensities; w unused
  AttractionView attraction;
  LevelsView levels;
  const StepCoefficients* coefficients = nullptr;  ///< one per mesh
  VolumeView volume;
  StepStatus* status = nullptr;

  template <class F>
  SIMPLEXSEG_HD Vec4* targets_of() const {
    return targets[static_cast<int>(F::id)];
  }
};

}  // namespace simplexseg
