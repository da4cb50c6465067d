// SPDX-License-Identifier: Apache-2.0
// Lanes that process one item together: one lane on the CPU, one or several threads of a warp on a device. A kernel
// written for lanes distributes its loops over them (k = lane, lane + width, ...), with the same source for both
// backends.
#pragma once
#include "core/vec3.h"

namespace simplexseg {

/// Single lane. Its scratch memory is on the stack, where the compiler can rule out aliasing.
struct OneLane {
  static constexpr int width = 1;
  static constexpr int lane = 0;
  static constexpr bool kEights = false;  ///< true for lanes that process eight vertices at once
  /// True if searches process values in order as they are computed, without storing them.
#ifdef __CUDA_ARCH__
  static constexpr bool kStreams = true;
#else
  static constexpr bool kStreams = false;
#endif
  using Serial = OneLane;  ///< lane type for code that is not distributed over lanes
  template <int kCapacity>
  struct Scratch {
    float values[kCapacity];
    SIMPLEXSEG_HD float& operator[](int k) { return values[k]; }
  };
  /// Temporary floats for one item, at most `kCapacity`. `first`: offset of these floats in the scratch memory, whose
  /// size the kernel requests by its member `scratch`.
  template <int kCapacity>
  SIMPLEXSEG_HD Scratch<kCapacity> scratch(int /*first*/) const {
    return {};
  }
  // Reductions over the values of all lanes; every lane gets the result.
  SIMPLEXSEG_HD unsigned smallest(unsigned x) const { return x; }
  SIMPLEXSEG_HD float sum(float x) const { return x; }
  SIMPLEXSEG_HD int count(bool x) const { return x ? 1 : 0; }
  SIMPLEXSEG_HD int count_before(bool) const { return 0; }       ///< number of lower lanes with a true value
  SIMPLEXSEG_HD bool first_of_equal(int) const { return true; }  ///< true if no lower lane has the same value
  /// Sum over items. Item k is added to partial sum k % 8, so that the total has the same bits as with eight vertices
  /// at once (forces/eight.h).
  struct Sum {
    alignas(32) float parts[8] = {};
    SIMPLEXSEG_HD void add(int item, float x) { parts[item % 8] += x; }
    /// Adds the eight items from `first`, which is a multiple of eight.
    template <class Floats>
    SIMPLEXSEG_HD void add(int /*first*/, Floats x) {
      add_to(parts, x);
    }
  };
  SIMPLEXSEG_HD float total(const Sum& s) const {
    const float* x = s.parts;
    return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
  }
  /// Barrier: waits for all lanes and makes their writes visible.
  SIMPLEXSEG_HD void sync() const {}
};

/// Block of the CPU: a single group of lanes. A kernel written for a block runs once, distributes its items over the
/// groups (k = group, group + groups, ...) and synchronises them where necessary. Its `kBlockThreads` is the number of
/// threads of its block on a device.
struct OneGroup {
  static constexpr int groups = 1, group = 0;
  static constexpr bool kUsesSharedMemory = false;  ///< true: kernels copy arrays to shared memory, which is faster
  OneLane lanes;
  SIMPLEXSEG_HD void sync() const {}
};

#ifdef __CUDACC__
/// Scratch floats in shared memory, `stride` floats apart.
struct SharedScratch {
  float* values;
  int stride;
  __device__ float& operator[](int k) const { return values[k * stride]; }
};
/// Single thread of a device. Its scratch memory is in shared memory, in one bank per thread.
struct ThreadLane : OneLane {
  float* shared;
  __device__ explicit ThreadLane(float* block_shared) : shared(block_shared) {}
  template <int kCapacity>
  __device__ SharedScratch scratch(int first) const {
    return {shared + first * static_cast<int>(blockDim.x) + threadIdx.x, static_cast<int>(blockDim.x)};
  }
};
/// Group of `kWidth` adjacent threads of a warp. All of them must call the same members in the same order.
template <int kWidth>
struct GroupLanes {
  static constexpr int width = kWidth;
  static constexpr bool kStreams = false;
  using Serial = OneLane;
  int lane;
  unsigned mask;
  float* shared;  ///< shared memory of the group
  template <int kCapacity>
  __device__ SharedScratch scratch(int first) const {
    return {shared + first, 1};
  }
  __device__ void sync() const { __syncwarp(mask); }
  template <class T>
  __device__ T shuffle_xor(T x, int step) const {
    return __shfl_xor_sync(mask, x, step, kWidth);
  }
  __device__ float sum(float x) const {
    // Butterfly reduction: the order of the additions is fixed.
    for (int step = kWidth / 2; step > 0; step /= 2) x += shuffle_xor(x, step);
    return x;
  }
};
/// All 32 threads of a warp, which must call the same members in the same order.
struct WarpLanes {
  static constexpr int width = 32;
  static constexpr bool kEights = false;
  int lane;
  static constexpr unsigned kAll = ~0u;
  __device__ void sync() const { __syncwarp(); }
  __device__ unsigned smallest(unsigned x) const { return __reduce_min_sync(kAll, x); }
  __device__ float sum(float x) const {
    // Butterfly reduction: the order of the additions is fixed.
    for (int step = 16; step > 0; step /= 2) x += __shfl_xor_sync(kAll, x, step);
    return x;
  }
  struct Sum {
    float lane_sum = 0;
    __device__ void add(int, float x) { lane_sum += x; }
  };
  __device__ float total(const Sum& s) const { return sum(s.lane_sum); }
  __device__ int count(bool x) const { return __popc(__ballot_sync(kAll, x)); }
  __device__ int count_before(bool x) const { return __popc(__ballot_sync(kAll, x) & ((1u << lane) - 1u)); }
  __device__ bool first_of_equal(int x) const { return (__match_any_sync(kAll, x) & ((1u << lane) - 1u)) == 0; }
};
#endif

}  // namespace simplexseg
