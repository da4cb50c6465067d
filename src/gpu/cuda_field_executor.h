// SPDX-License-Identifier: Apache-2.0
// CUDA executor of the field solver; its interface is documented in field/parallel/executor.h. Included only by CUDA
// sources.
#pragma once
#include <cuda_runtime.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "core/expect.h"
#include "field/parallel/executor.h"
#include "field/run_jobs.h"
#include "field/update_progress.h"
#include "gpu/cuda_field_kernels.h"
#include "gpu/cuda_memory.h"

namespace simplexseg {

/// CUDA event: a position in a stream that the host can wait for.
class Event {
 public:
  Event() { check(cudaEventCreateWithFlags(&handle_, cudaEventDisableTiming), "creating an event"); }
  ~Event() { cudaEventDestroy(handle_); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  cudaEvent_t handle() const { return handle_; }

 private:
  cudaEvent_t handle_ = nullptr;
};

/// Executor of the field solver on a CUDA device. It must outlive its arrays, and one thread at a time may use it.
class CudaFieldExecutor {
 public:
  /// The parameter is the CPU's (CpuFieldExecutor).
  explicit CudaFieldExecutor(const RunJobs& = {}) : stream_("simplexseg evidence field") {
    fetch_buffer_.resize(2 * kFetched);
    block_sums_ = Array<double>(*this, kMostSums * field_kernels::kMaxBlocks, 0);
    ended_ = Array<unsigned>(*this, 1, 0);
    clear(ended_.data(), 1);
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "selecting a device");
    check(cudaGetDeviceProperties(&properties, device), "reading the device properties");
    processors_ = properties.multiProcessorCount;
    totals_ = Array<Totals>(*this, 2 * std::size_t(processors_), 0);
    // Launches may overlap only if wait_for_earlier_kernels() was compiled for compute capability 9.0 or higher.
    cudaFuncAttributes attributes{};
    check(cudaFuncGetAttributes(&attributes, field_kernels::probe), "reading kernel attributes");
    overlaps_ = properties.major >= 9 && attributes.ptxVersion >= 90;
  }
  ~CudaFieldExecutor() { cudaStreamSynchronize(stream_.handle()); }
  CudaFieldExecutor(const CudaFieldExecutor&) = delete;
  CudaFieldExecutor& operator=(const CudaFieldExecutor&) = delete;

  template <class T>
  class Array {
   public:
    Array() = default;
    Array(const CudaFieldExecutor& executor, std::size_t size, std::size_t pad)
        : stream_(executor.stream_.handle()), size_(size), pad_(pad) {
      if (size == 0) return;
      base_ = static_cast<T*>(
          executor.memory_->allocate((size + 2 * pad) * sizeof(T), stream_, "allocating the evidence field"));
      if (pad != 0)
        check(cudaMemsetAsync(base_, 0, (size + 2 * pad) * sizeof(T), stream_), "clearing the evidence field");
    }
    ~Array() {
      if (base_ != nullptr) cudaFreeAsync(base_, stream_);
    }
    Array(Array&& other) noexcept { swap(other); }
    Array& operator=(Array&& other) noexcept {
      swap(other);
      return *this;
    }
    T* data() const { return base_ == nullptr ? nullptr : base_ + pad_; }
    std::size_t size() const { return size_; }
    std::size_t bytes() const { return base_ == nullptr ? 0 : (size_ + 2 * pad_) * sizeof(T); }

   private:
    void swap(Array& other) noexcept {
      std::swap(stream_, other.stream_), std::swap(base_, other.base_);
      std::swap(size_, other.size_), std::swap(pad_, other.pad_);
    }
    cudaStream_t stream_ = nullptr;
    T* base_ = nullptr;
    std::size_t size_ = 0, pad_ = 0;
  };

  template <class T>
  Array<T> array(std::size_t size) const {
    return {*this, size, 0};
  }
  template <class T>
  Array<T> padded(const BoxGrid& grid) const {
    return {*this, static_cast<std::size_t>(grid.count()), static_cast<std::size_t>(grid.plane())};
  }
  template <class T>
  Array<T> copy_of(std::span<const T> from) const {
    Array<T> to(*this, from.size(), 0);
    upload(from, to.data());
    return to;
  }
  template <class T>
  void upload(std::span<const T> from, T* to) const {
    if (!from.empty()) stream_.upload(to, from.data(), from.size_bytes());
  }
  template <class T>
  void download(const T* from, std::span<T> to) const {
    if (!to.empty()) stream_.download(to.data(), from, to.size_bytes());
  }
  template <class T>
  struct Fetched {
    const unsigned char* at;  ///< destination of the transfer, in pinned memory
    cudaEvent_t there;        ///< recorded after the transfer
  };
  template <class T>
  Fetched<T> fetch(const T* from, std::size_t count) const {
    const std::size_t bytes = count * sizeof(T);
    SIMPLEXSEG_EXPECT(bytes <= kFetched);
    if (fetched_ + bytes > 2 * kFetched) fetched_ = 0;  // transfers in flight need at most half of it
    unsigned char* const to = fetch_buffer_.data() + fetched_;
    fetched_ += (bytes + 15) / 16 * 16;
    cudaEvent_t there = events_[next_event_++ % events_.size()].handle();
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_.handle()), "download");
    check(cudaEventRecord(there, stream_.handle()), "download");
    return {to, there};
  }
  template <class T>
  void receive(const Fetched<T>& fetched, std::span<T> to) const {
    check(cudaEventSynchronize(fetched.there), "waiting for the device");
    std::memcpy(to.data(), fetched.at, to.size_bytes());
  }
  template <class T>
  void copy(const T* from, T* to, std::size_t count) const {
    if (count != 0)
      check(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyDeviceToDevice, stream_.handle()), "copying");
  }
  template <class T>
  void clear(T* at, std::size_t count) const {
    if (count != 0) check(cudaMemsetAsync(at, 0, count * sizeof(T), stream_.handle()), "clearing");
  }
  /// Waits for all work on the stream.
  void wait() const { stream_.wait(); }

  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    using namespace field_kernels;
    if (n > 0) start((n + kThreads - 1) / kThreads, kThreads, field_kernels::each<Kernel>, kernel, n);
  }
  static constexpr bool kHostMemory = false, kCellsInOrder = false;
  template <class Kernel>
  void each_cell(const BoxGrid& grid, const Kernel& kernel) const {
    each(grid.count(), KernelOfCells<Kernel>{grid, kernel});
  }
  template <class Kernel>
  void each_lanes(int n, const Kernel& kernel) const {
    each(n, field_kernels::OneLane<Kernel>{kernel});
  }
  template <class Kernel>
  void each_cell_lanes(const BoxGrid& grid, const Kernel& kernel) const {
    each_cell(grid, field_kernels::OneLane<Kernel>{kernel});
  }
  template <class Kernel>
  void all(const Kernel& kernel, const ReportProgress& = {}) const {
    using namespace field_kernels;
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(static_cast<unsigned>(processors_));
    config.blockDim = dim3(kGridBlockThreads);
    config.stream = stream_.handle();
    cudaLaunchAttribute cooperative{};
    cooperative.id = cudaLaunchAttributeCooperative;
    cooperative.val.cooperative = 1;
    config.attrs = &cooperative;
    config.numAttrs = 1;
    check(cudaLaunchKernelEx(&config, run_grid<Kernel>, kernel, totals_.data()), "the evidence field");
  }
  template <class Kernel>
  void blocks(int count, const Kernel& kernel) const {
    if (count > 0) start(count, field_kernels::kBlockThreads, field_kernels::run_blocks<Kernel>, kernel);
  }
  template <class Kernel>
  void sums_into(int n, const Kernel& kernel, double* to) const {
    using namespace field_kernels;
    static_assert(decltype(kernel(0))::kCount <= kMostSums);
    start(blocks_of_sum(n), kThreads, sums<Kernel>, kernel, n, block_sums_.data(), ended_.data(), to);
  }
  template <class Kernel>
  void histogram(int n, const Kernel& kernel, int* count) const {
    using namespace field_kernels;
    if (n > 0) start(blocks_of_sum(n), kThreads, field_kernels::histogram<Kernel>, kernel, n, count);
  }

 private:
  static constexpr std::size_t kFetched = 128 * 1024;

  int blocks_of_sum(int n) const {
    using namespace field_kernels;
    return std::clamp((n + 4 * kThreads - 1) / (4 * kThreads), 1, std::min(kMaxBlocks, 3 * processors_));
  }
  template <class... Parameters, class... Arguments>
  void start(int blocks, int threads, void (*kernel)(Parameters...), const Arguments&... arguments) const {
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(static_cast<unsigned>(blocks));
    config.blockDim = dim3(static_cast<unsigned>(threads));
    config.stream = stream_.handle();
    cudaLaunchAttribute overlap{};
    overlap.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    overlap.val.programmaticStreamSerializationAllowed = 1;
    config.attrs = &overlap;
    config.numAttrs = overlaps_ ? 1 : 0;
    check(cudaLaunchKernelEx(&config, kernel, arguments...), "the evidence field");
  }

  std::shared_ptr<const DeviceMemory> memory_ = DeviceMemory::for_current_device();
  mutable Stream stream_;
  mutable HostVisibleArray<unsigned char> fetch_buffer_;  ///< ring buffer of 2 * kFetched bytes
  mutable std::size_t fetched_ = 0;                       ///< offset of the next transfer, bytes
  /// Events of the transfers, used in rotation: with more than eight transfers in flight, receive() of the oldest one
  /// waits for a later one.
  std::array<Event, 8> events_;
  mutable std::size_t next_event_ = 0;
  Array<double> block_sums_;
  Array<unsigned> ended_;
  Array<Totals> totals_;
  int processors_ = 1;
  bool overlaps_ = false;
};

}  // namespace simplexseg
