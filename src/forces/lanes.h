// SPDX-License-Identifier: Apache-2.0
// Lanes that work on one item together: one on the CPU, several threads of a warp on a device. A kernel that is written
// for lanes shares out its loops (k = lane, lane + width, ...) and is the same source on both.
#pragma once
#include "core/vec3.h"

namespace simplexseg {

/// One lane that does all. Scratch is on the stack, where the compiler sees that nothing else points to it.
struct OneLane {
  static constexpr int width = 1;
  static constexpr int lane = 0;
  static constexpr bool kEights = false;  ///< it takes eight vertices at once
  /// Values are taken as they come, in order, and none is kept.
#ifdef __CUDA_ARCH__
  static constexpr bool kStreams = true;
#else
  static constexpr bool kStreams = false;
#endif
  using Alone = OneLane;  ///< what does by itself what is not shared out
  template <int kMost>
  struct Scratch {
    float values[kMost];
    SIMPLEXSEG_HD float& operator[](int k) { return values[k]; }
  };
  /// Floats that live while the item is worked on: `kMost` at most, and `count` of them from `first` on of those that
  /// the kernel asked for in its member `scratch`.
  template <int kMost>
  SIMPLEXSEG_HD Scratch<kMost> scratch(int /*first*/) const {
    return {};
  }
  // Over the values of all lanes; every lane gets the result.
  SIMPLEXSEG_HD unsigned smallest(unsigned x) const { return x; }
  SIMPLEXSEG_HD float sum(float x) const { return x; }
  SIMPLEXSEG_HD int count(bool x) const { return x ? 1 : 0; }
  SIMPLEXSEG_HD int count_before(bool) const { return 0; }       ///< in lower lanes
  SIMPLEXSEG_HD bool first_of_equal(int) const { return true; }  ///< no lower lane has the same value
  /// A sum over items: of every eighth by itself, so that it is the same where eight are added at once
  /// (forces/eight.h).
  struct Sum {
    alignas(32) float parts[8] = {};
    SIMPLEXSEG_HD void add(int item, float x) { parts[item % 8] += x; }
    /// Of eight items from `first`, a multiple of eight, on.
    template <class Floats>
    SIMPLEXSEG_HD void add(int /*first*/, Floats x) {
      add_to(parts, x);
    }
  };
  SIMPLEXSEG_HD float total(const Sum& s) const {
    const float* x = s.parts;
    return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
  }
  /// Waits until all lanes have come here; what they wrote is seen.
  SIMPLEXSEG_HD void sync() const {}
};

/// Groups of lanes that go through a kernel together, each with its own items (k = group, group + groups, ...): a
/// kernel that is written for a team (`kTeam`, its threads on a device) is run once, and waits for all of them where it
/// must.
struct OneGroup {
  static constexpr int groups = 1, group = 0;
  static constexpr bool kOwnMemory = false;  ///< has memory that is nearer than that of the arrays
  OneLane lanes;
  SIMPLEXSEG_HD void sync() const {}
};

#ifdef __CUDACC__
/// Floats of shared memory, `stride` apart.
struct SharedScratch {
  float* values;
  int stride;
  __device__ float& operator[](int k) const { return values[k * stride]; }
};
/// A thread by itself: scratch is in shared memory, one bank a thread.
struct ThreadLane : OneLane {
  float* shared;
  __device__ explicit ThreadLane(float* block_shared) : shared(block_shared) {}
  template <int kMost>
  __device__ SharedScratch scratch(int first) const {
    return {shared + first * static_cast<int>(blockDim.x) + threadIdx.x, static_cast<int>(blockDim.x)};
  }
};
/// `kWidth` neighbouring threads of a warp. All of them must call the same members in the same order.
template <int kWidth>
struct GroupLanes {
  static constexpr int width = kWidth;
  static constexpr bool kStreams = false;
  using Alone = OneLane;
  int lane;
  unsigned mask;
  float* shared;  ///< of the group
  template <int kMost>
  __device__ SharedScratch scratch(int first) const {
    return {shared + first, 1};
  }
  __device__ void sync() const { __syncwarp(mask); }
  template <class T>
  __device__ T from_lane_across(T x, int step) const {
    return __shfl_xor_sync(mask, x, step, kWidth);
  }
  __device__ float sum(float x) const {
    // Butterflies: the order of adding is the same in every run.
    for (int step = kWidth / 2; step > 0; step /= 2) x += from_lane_across(x, step);
    return x;
  }
};
/// A warp. All its threads must call the same members in the same order.
struct WarpLanes {
  static constexpr int width = 32;
  static constexpr bool kEights = false;
  int lane;
  static constexpr unsigned kAll = ~0u;
  __device__ void sync() const { __syncwarp(); }
  __device__ unsigned smallest(unsigned x) const { return __reduce_min_sync(kAll, x); }
  __device__ float sum(float x) const {
    // Butterflies: the order of adding is the same in every run.
    for (int step = 16; step > 0; step /= 2) x += __shfl_xor_sync(kAll, x, step);
    return x;
  }
  struct Sum {
    float own = 0;
    __device__ void add(int, float x) { own += x; }
  };
  __device__ float total(const Sum& s) const { return sum(s.own); }
  __device__ int count(bool x) const { return __popc(__ballot_sync(kAll, x)); }
  __device__ int count_before(bool x) const { return __popc(__ballot_sync(kAll, x) & ((1u << lane) - 1u)); }
  __device__ bool first_of_equal(int x) const { return (__match_any_sync(kAll, x) & ((1u << lane) - 1u)) == 0; }
};
#endif

}  // namespace simplexseg
