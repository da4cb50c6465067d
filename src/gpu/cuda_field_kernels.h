// SPDX-License-Identifier: Apache-2.0
// How a device's blocks of threads run what the evidence field's executor is given (gpu/cuda_field_executor.h).
// Included by CUDA sources alone.
#pragma once
#include <cooperative_groups.h>
#include <cuda_runtime.h>

#include "evidence/parallel/executor.h"

namespace simplexseg {
namespace field_kernels {

constexpr int kThreads = 256, kOfAll = 1024, kOfTeams = 512, kWarp = 32;
constexpr int kMostBlocks = 512;  ///< of a sum: what the last one adds up

/// As in cuda_engine.cu: the blocks of a kernel come while the last ones of the kernel before end, and wait here.
__device__ inline void wait_for_earlier_kernels() {
#if __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

template <class Kernel>
__global__ void __launch_bounds__(kThreads) each(const __grid_constant__ Kernel kernel, int n) {
  wait_for_earlier_kernels();
  const int v = static_cast<int>(blockIdx.x) * kThreads + static_cast<int>(threadIdx.x);
  if (v < n) kernel(v);
}

static __global__ void probe() {}

template <int kCount>
struct BlockAsTeam {
  static constexpr int threads = kCount;
  int thread;
  float* scratch;
  SIMPLEXSEG_HD void sync() const {
#ifdef __CUDA_ARCH__
    __syncthreads();
#endif
  }
  /// The first of its threads, which wait for each other alone.
  struct Few {
    static constexpr int threads = kWarp;
    int thread;
    SIMPLEXSEG_HD void sync() const {
#ifdef __CUDA_ARCH__
      __syncwarp();
#endif
    }
  };
  template <class Kernel>
  SIMPLEXSEG_HD void few(const Kernel& kernel) const {
    if (thread < kWarp) kernel(Few{thread});
    sync();
  }
  /// Whether any of its threads says so.
  SIMPLEXSEG_HD bool any([[maybe_unused]] bool x) const {
#ifdef __CUDA_ARCH__
    return __syncthreads_or(x) != 0;
#else
    return x;
#endif
  }
};
/// A team for each block.
template <class Kernel>
__global__ void __launch_bounds__(kOfTeams) by_teams(const __grid_constant__ Kernel kernel) {
  __shared__ float scratch[Kernel::kScratch];
  wait_for_earlier_kernels();
  kernel(BlockAsTeam<kOfTeams>{static_cast<int>(threadIdx.x), scratch}, static_cast<int>(blockIdx.x));
}

/// Of all threads of a block, in a tree that is always the same; the first thread has it.
template <int kCount>
__device__ Totals of_block(Totals x) {
  __shared__ Totals of_warp[kCount / kWarp];
  for (int step = kWarp / 2; step > 0; step /= 2) {
    x.sum += __shfl_down_sync(~0u, x.sum, step);
    x.largest = larger(__shfl_down_sync(~0u, x.largest, step), x.largest);
  }
  if (threadIdx.x % kWarp == 0) of_warp[threadIdx.x / kWarp] = x;
  __syncthreads();
  if (threadIdx.x == 0)
    for (int w = 1; w < kCount / kWarp; ++w) {
      x.sum += of_warp[w].sum;
      x.largest = larger(of_warp[w].largest, x.largest);
    }
  __syncthreads();
  return x;
}

/// Bins of kernel(v) for v = first, first + stride, ... < n, each block's counted in its own memory first.
template <int kCount, class Kernel>
__device__ void count_bins(int n, const Kernel& kernel, int* count, int first, int stride) {
  __shared__ int own[kBins];
  for (int b = static_cast<int>(threadIdx.x); b < kBins; b += kCount) own[b] = 0;
  __syncthreads();
  for (int v = first; v < n; v += stride) {
    const int bin = kernel(v);
    if (bin >= 0 && bin < kBins) atomicAdd(&own[bin], 1);
  }
  __syncthreads();
  for (int b = static_cast<int>(threadIdx.x); b < kBins; b += kCount)
    if (own[b] != 0) atomicAdd(&count[b], own[b]);
  __syncthreads();
}

/// The last block to end puts together what all blocks have, in their order.
template <class Kernel>
__global__ void __launch_bounds__(kThreads)
    sums(const __grid_constant__ Kernel kernel, int n, double* of_blocks, unsigned* ended, double* to) {
  wait_for_earlier_kernels();
  constexpr int kCount = decltype(kernel(0))::kCount;
  SumsOf<kCount> x{};
  const int stride = static_cast<int>(gridDim.x) * kThreads;
  for (int v = static_cast<int>(blockIdx.x) * kThreads + static_cast<int>(threadIdx.x); v < n; v += stride)
    add(kernel(v), x);
  __shared__ bool last;
  for (int s = 0; s < kCount; ++s) {
    const double sum = of_block<kThreads>({x.is[s], 0}).sum;
    if (threadIdx.x == 0) of_blocks[blockIdx.x * kCount + s] = sum;
  }
  if (threadIdx.x == 0) {
    __threadfence();
    last = atomicAdd(ended, 1u) == gridDim.x - 1;
  }
  __syncthreads();
  if (!last) return;
  __threadfence();
  for (int s = 0; s < kCount; ++s) {
    double sum = 0;
    for (unsigned b = threadIdx.x; b < gridDim.x; b += kThreads)
      sum += const_cast<const volatile double*>(of_blocks)[b * kCount + s];
    sum = of_block<kThreads>({sum, 0}).sum;
    if (threadIdx.x == 0) to[s] = sum;
  }
  if (threadIdx.x == 0) *ended = 0;
}

/// All threads of a cooperative launch.
class GridAsAll {
  static constexpr unsigned kGroup = 128;

 public:
  /// `of_blocks`: room for two Totals for each block.
  __device__ explicit GridAsAll(Totals* of_blocks) : of_blocks_(of_blocks) {}

  template <class Kernel>
  __device__ void each(int n, const Kernel& kernel) const {
    for (int v = first(); v < n; v += stride()) kernel(v);
    cooperative_groups::this_grid().sync();
  }
  template <class Kernel>
  __device__ Totals totals(int n, const Kernel& kernel) const {
    Totals x;
    for (int v = first(); v < n; v += stride()) {
      const OfTotals of = kernel(v);
      x.sum += of.value;
      x.largest = larger(of.size, x.largest);
    }
    x = of_block<kOfAll>(x);
    // Twice, by turns: the next ones may be written before all threads have read these.
    Totals* const of_blocks = of_blocks_ + (turn_ ^= 1) * gridDim.x;
    if (threadIdx.x == 0) of_blocks[blockIdx.x] = x;
    cooperative_groups::this_grid().sync();
    x = {};
    for (unsigned b = threadIdx.x; b < gridDim.x; b += kOfAll) {
      x.sum += of_blocks[b].sum;
      x.largest = larger(of_blocks[b].largest, x.largest);
    }
    __shared__ Totals all;
    x = of_block<kOfAll>(x);
    if (threadIdx.x == 0) all = x;
    __syncthreads();
    return all;
  }
  template <class Kernel>
  __device__ void histogram(int n, const Kernel& kernel, int* count) const {
    count_bins<kOfAll>(n, kernel, count, first(), stride());
    cooperative_groups::this_grid().sync();
  }
  template <class Kernel>
  __device__ void some(const Kernel& kernel) const {
    if (blockIdx.x == 0) kernel(BlockAsTeam<kOfAll>{static_cast<int>(threadIdx.x), nullptr});
    cooperative_groups::this_grid().sync();
  }
  __device__ bool is_first() const { return first() == 0; }

 private:
  /// Neighbours by whole groups in different blocks: where there is little to do all processors share in it.
  __device__ int first() const {
    const unsigned group = threadIdx.x / kGroup * gridDim.x + blockIdx.x;
    return static_cast<int>(group * kGroup + threadIdx.x % kGroup);
  }
  __device__ int stride() const { return static_cast<int>(gridDim.x) * kOfAll; }

  Totals* of_blocks_;
  mutable unsigned turn_ = 0;
};
template <class Kernel>
__global__ void __launch_bounds__(kOfAll, 1) by_all(const __grid_constant__ Kernel kernel, Totals* of_blocks) {
  kernel(GridAsAll(of_blocks));
}

template <class Kernel>
__global__ void __launch_bounds__(kThreads) histogram(const __grid_constant__ Kernel kernel, int n, int* count) {
  wait_for_earlier_kernels();
  const int first = static_cast<int>(blockIdx.x) * kThreads + static_cast<int>(threadIdx.x);
  count_bins<kThreads>(n, kernel, count, first, static_cast<int>(gridDim.x) * kThreads);
}

}  // namespace field_kernels

}  // namespace simplexseg
