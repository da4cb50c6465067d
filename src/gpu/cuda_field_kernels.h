// SPDX-License-Identifier: Apache-2.0
// CUDA kernels that run the functors of the field solver (gpu/cuda_field_executor.h). Included only by CUDA sources.
#pragma once
#include <cooperative_groups.h>
#include <cuda_runtime.h>

#include "field/parallel/executor.h"

namespace simplexseg {
namespace field_kernels {

constexpr int kThreads = 256, kGridBlockThreads = 1024, kBlockThreads = 512, kWarp = 32;
constexpr int kMaxBlocks = 512;  ///< largest number of blocks in a launch of sums() or histogram()

/// Waits for the results of the previous kernel, which may still be running when this kernel starts (cuda_engine.cu).
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

/// kernel.run<1>(v) as a kernel.
template <class Kernel>
struct OneLane {
  Kernel kernel;
  template <class Cell>
  SIMPLEXSEG_HD void operator()(const Cell& cell) const {
    kernel.template run<1>(cell);
  }
};

template <int kCount>
struct FieldBlock {
  static constexpr bool kByRows = false;
  static constexpr int threads = kCount;
  int thread;
  float* scratch;
  SIMPLEXSEG_HD void sync() const {
#ifdef __CUDA_ARCH__
    __syncthreads();
#endif
  }
  /// First warp of the block; sync() waits only for the threads of this warp.
  struct Warp {
    static constexpr bool kByRows = false;
    static constexpr int threads = kWarp;
    int thread;
    SIMPLEXSEG_HD void sync() const {
#ifdef __CUDA_ARCH__
      __syncwarp();
#endif
    }
  };
  template <class Kernel>
  SIMPLEXSEG_HD void warp(const Kernel& kernel) const {
    if (thread < kWarp) kernel(Warp{thread});
    sync();
  }
  /// True if `x` is true in any thread of the block.
  SIMPLEXSEG_HD bool any([[maybe_unused]] bool x) const {
#ifdef __CUDA_ARCH__
    return __syncthreads_or(x) != 0;
#else
    return x;
#endif
  }
};
/// Calls kernel(block, index) with all threads of each block; index: index of the block.
template <class Kernel>
__global__ void __launch_bounds__(kBlockThreads) run_blocks(const __grid_constant__ Kernel kernel) {
  __shared__ float scratch[Kernel::kScratch];
  wait_for_earlier_kernels();
  kernel(FieldBlock<kBlockThreads>{static_cast<int>(threadIdx.x), scratch}, static_cast<int>(blockIdx.x));
}

/// Totals over all kCount threads of a block, added in a fixed order: within each warp, then over the warps. Valid only
/// in the first thread.
template <int kCount>
__device__ Totals block_total(Totals x) {
  __shared__ Totals warp_totals[kCount / kWarp];
  for (int step = kWarp / 2; step > 0; step /= 2) {
    x.sum += __shfl_down_sync(~0u, x.sum, step);
    x.largest = larger(__shfl_down_sync(~0u, x.largest, step), x.largest);
  }
  if (threadIdx.x % kWarp == 0) warp_totals[threadIdx.x / kWarp] = x;
  __syncthreads();
  if (threadIdx.x == 0)
    for (int w = 1; w < kCount / kWarp; ++w) {
      x.sum += warp_totals[w].sum;
      x.largest = larger(warp_totals[w].largest, x.largest);
    }
  __syncthreads();
  return x;
}

/// Adds the histogram of kernel(v), v = first, first + stride, ... < n, to `count`, which has kBins bins. Each block
/// first counts in shared memory.
template <int kCount, class Kernel>
__device__ void count_bins(int n, const Kernel& kernel, int* count, int first, int stride) {
  __shared__ int block_count[kBins];
  for (int b = static_cast<int>(threadIdx.x); b < kBins; b += kCount) block_count[b] = 0;
  __syncthreads();
  for (int v = first; v < n; v += stride) {
    const int bin = kernel(v);
    if (bin >= 0 && bin < kBins) atomicAdd(&block_count[bin], 1);
  }
  __syncthreads();
  for (int b = static_cast<int>(threadIdx.x); b < kBins; b += kCount)
    if (block_count[b] != 0) atomicAdd(&count[b], block_count[b]);
  __syncthreads();
}

/// Writes the sums of kernel(v) over all v < n to `to`. The last block to finish adds the sums of all blocks
/// (`block_sums`) in a fixed order. `ended`: number of finished blocks, 0 before and after the launch.
template <class Kernel>
__global__ void __launch_bounds__(kThreads)
    sums(const __grid_constant__ Kernel kernel, int n, double* block_sums, unsigned* ended, double* to) {
  wait_for_earlier_kernels();
  constexpr int kCount = decltype(kernel(0))::kCount;
  SumsOf<kCount> x{};
  const int stride = static_cast<int>(gridDim.x) * kThreads;
  for (int v = static_cast<int>(blockIdx.x) * kThreads + static_cast<int>(threadIdx.x); v < n; v += stride)
    add(kernel(v), x);
  __shared__ bool last;
  for (int s = 0; s < kCount; ++s) {
    const double sum = block_total<kThreads>({x.values[s], 0}).sum;
    if (threadIdx.x == 0) block_sums[blockIdx.x * kCount + s] = sum;
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
      sum += const_cast<const volatile double*>(block_sums)[b * kCount + s];
    sum = block_total<kThreads>({sum, 0}).sum;
    if (threadIdx.x == 0) to[s] = sum;
  }
  if (threadIdx.x == 0) *ended = 0;
}

/// All threads of a cooperative launch, with the interface of CpuGrid (field/parallel/cpu_executor.h).
class GridThreads {
  static constexpr unsigned kGroup = 128;

 public:
  static constexpr bool kByRows = false;

  /// `block_totals`: workspace of two Totals for each block.
  __device__ explicit GridThreads(Totals* block_totals) : block_totals_(block_totals) {}

  template <class Kernel>
  __device__ void each(int n, const Kernel& kernel) const {
    for (int v = first(); v < n; v += stride()) kernel(v);
    cooperative_groups::this_grid().sync();
  }
  template <class Kernel>
  __device__ Totals totals(int n, const Kernel& kernel) const {
    Totals x;
    for (int v = first(); v < n; v += stride()) {
      const Contribution of = kernel(v);
      x.sum += of.value;
      x.largest = larger(of.magnitude, x.largest);
    }
    x = block_total<kGridBlockThreads>(x);
    // Two buffers are used alternately: a block may write the next totals before all threads have read the current
    // ones.
    Totals* const block_totals = block_totals_ + (buffer_ ^= 1) * gridDim.x;
    if (threadIdx.x == 0) block_totals[blockIdx.x] = x;
    cooperative_groups::this_grid().sync();
    x = {};
    for (unsigned b = threadIdx.x; b < gridDim.x; b += kGridBlockThreads) {
      x.sum += block_totals[b].sum;
      x.largest = larger(block_totals[b].largest, x.largest);
    }
    __shared__ Totals all;
    x = block_total<kGridBlockThreads>(x);
    if (threadIdx.x == 0) all = x;
    __syncthreads();
    return all;
  }
  template <class Kernel>
  __device__ void histogram(int n, const Kernel& kernel, int* count) const {
    count_bins<kGridBlockThreads>(n, kernel, count, first(), stride());
    cooperative_groups::this_grid().sync();
  }
  template <class Kernel>
  __device__ void by_one_block(const Kernel& kernel) const {
    if (blockIdx.x == 0) kernel(FieldBlock<kGridBlockThreads>{static_cast<int>(threadIdx.x), nullptr});
    cooperative_groups::this_grid().sync();
  }
  __device__ bool is_first() const { return first() == 0; }
  __device__ void report(float, float, double) const {}

 private:
  /// First index of this thread. Consecutive groups of kGroup indices belong to different blocks, so that short loops
  /// use all multiprocessors.
  __device__ int first() const {
    const unsigned group = threadIdx.x / kGroup * gridDim.x + blockIdx.x;
    return static_cast<int>(group * kGroup + threadIdx.x % kGroup);
  }
  __device__ int stride() const { return static_cast<int>(gridDim.x) * kGridBlockThreads; }

  Totals* block_totals_;
  mutable unsigned buffer_ = 0;
};
template <class Kernel>
__global__ void __launch_bounds__(kGridBlockThreads, 1)
    run_grid(const __grid_constant__ Kernel kernel, Totals* block_totals) {
  kernel(GridThreads(block_totals));
}

template <class Kernel>
__global__ void __launch_bounds__(kThreads) histogram(const __grid_constant__ Kernel kernel, int n, int* count) {
  wait_for_earlier_kernels();
  const int first = static_cast<int>(blockIdx.x) * kThreads + static_cast<int>(threadIdx.x);
  count_bins<kThreads>(n, kernel, count, first, static_cast<int>(gridDim.x) * kThreads);
}

}  // namespace field_kernels

}  // namespace simplexseg
