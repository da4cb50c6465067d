// SPDX-License-Identifier: Apache-2.0
#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "core/thread_pool.h"
#include "gpu/backend.h"
#include "gpu/eight_vertices.h"
#include "gpu/step_engine.h"

namespace simplexseg_avx2 {
const void* eight_vertices();
}

namespace simplexseg {
namespace {

/// Table of the AVX2 kernels; nullptr if they were not compiled or the CPU lacks AVX2, BMI2 or FMA.
const EightVertices* eight_vertices() {
#if defined(__x86_64__)
  const bool supported =
      __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma");
  return supported ? static_cast<const EightVertices*>(simplexseg_avx2::eight_vertices()) : nullptr;
#else
  return nullptr;
#endif
}

/// Array in host memory, aligned to 64 bytes, or to 2 MiB if at least as large. resize() leaves the contents undefined.
template <class T>
class HostArray {
 public:
  T* data() { return data_.get(); }
  auto texels() const {
    if constexpr (std::is_same_v<T, Int4>)
      return NeighbourTexels{data_.get()};
    else
      return Texels<T>{data_.get()};
  }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }
  void resize(std::size_t n) {
    if (n == size_) return;
    data_.reset();
    size_ = 0;
    if (n == 0) return;
    // Huge pages reduce TLB misses: each step reads all arrays.
    constexpr std::size_t kHugePage = std::size_t{2} << 20;
    const std::size_t alignment = n * sizeof(T) >= kHugePage ? kHugePage : 64;
    const std::size_t bytes = (n * sizeof(T) + alignment - 1) / alignment * alignment;
    data_.reset(static_cast<T*>(std::aligned_alloc(alignment, bytes)));
#if defined(__linux__)
    if (data_ && alignment == kHugePage) (void)madvise(data_.get(), bytes, MADV_HUGEPAGE);  // failure is harmless
#endif
    if (!data_)
      throw Error("not enough memory", std::to_string(bytes >> 20) + " MiB could not be allocated",
                  "use fewer or coarser meshes");
    size_ = n;
  }
  void upload(std::span<const T> from, std::size_t first = 0) {
    std::copy(from.begin(), from.end(), data_.get() + first);
  }
  void assign(std::span<const T> from) { resize(from.size()), upload(from); }
  void assign_async(std::span<const T> from) { assign(from); }
  void download(std::span<T> to, std::size_t first = 0) { std::copy_n(data_.get() + first, to.size(), to.begin()); }
  void fill_zero() { fill(0); }
  void fill_ones() { fill(0xff); }

 private:
  void fill(int byte) {
    if (size_ != 0) std::memset(static_cast<void*>(data_.get()), byte, bytes());
  }
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  std::unique_ptr<T[], Free> data_;
  std::size_t size_ = 0;
};

/// Values in host memory that kernels read in place.
template <class T>
class HostView {
 public:
  void share(std::span<const T> values) { values_ = values; }
  const T* data() const { return values_.data(); }

 private:
  std::span<const T> values_;
};

/// Runs kernels on the CPU in blocks of fixed size, so that results do not depend on the number of threads.
class CpuExecutor {
 public:
  static constexpr const char* name = "cpu";
  template <class T>
  using Array = HostArray<T>;
  template <class T>
  using HostVisible = HostArray<T>;
  template <class T>
  using Shared = HostView<T>;
  using NeighbourArray = HostArray<Int4>;
  static constexpr bool kRecords = false, kSumsRings = true, kTiles = false;
  static constexpr float kCycleCost = 2.4f;  ///< duration of a step with a multigrid cycle, relative to a step without
  struct Recording {};
  explicit CpuExecutor(int threads, CpuCode code)
      : pool_(std::make_unique<ThreadPool>(threads)), eights_(code == CpuCode::Plain ? nullptr : eight_vertices()) {}
  std::string description() const {
    return "CPU, " + std::to_string(pool_->threads()) + (pool_->threads() == 1 ? " thread" : " threads");
  }

  void bind(const Volume& volume, VolumeView& view) {
    view = {};
    view.voxels = volume.data();
  }
  template <class F>
  void visit_voxels(VoxelType type, F&& f) const {
    visit_voxel_type(type, [&]<class T>(std::type_identity<T>) { f(std::type_identity<LinearVoxels<T>>{}); });
  }
  template <class F>
  void visit_width(int, F&& f) const {
    f(std::integral_constant<int, 1>{});
  }
  bool failed(const StepStatus* status) const { return status->failure != ~0ull; }
  void wait() {}
  int range(const char*) const { return 0; }
  std::unique_ptr<SharedBuffer> share_buffer(unsigned, std::size_t) { return nullptr; }
  std::uint64_t bytes_read_back() const { return 0; }
  std::size_t bytes_free() const { return std::numeric_limits<std::size_t>::max(); }  // no limit: the system can swap
  template <class T, class F>
  void draw(DrawTarget<T> target, std::size_t n, HostArray<T>&, F&& write) {
    if (target.host.size() < n)
      throw Error("drawing", "the buffer is too small", "pass a buffer with one element per drawn element");
    write(target.host.data());
  }

  template <class A, class B>
  void run_concurrently(const A& a, int na, const B& b, int nb) {
    run(b, nb);
    run_over_vertices(a, na);
  }
  template <class Kernel>
  void run(const Kernel& kernel) {
    kernel(OneGroup{});
  }
  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    run_blocks((n + kBlock - 1) / kBlock, [&](int b) { run_range(kernel, b * kBlock, std::min(n, (b + 1) * kBlock)); });
  }
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    if (active_.empty()) return run(kernel, n);
    run_blocks(static_cast<int>(active_.size()), [&](int b) { run_range(kernel, active_[b].first, active_[b].last); });
  }
  /// Restricts later runs over vertices to these ranges; an empty list removes the restriction.
  void restrict_vertices(const std::vector<VertexRange>& ranges) {
    active_.clear();
    for (const VertexRange& range : ranges)
      for (int first = range.first; first < range.last; first += kBlock)
        active_.push_back({first, std::min(first + kBlock, range.last)});
  }

 private:
  static constexpr int kBlock = 256;
  /// Calls run_block(0) ... run_block(blocks - 1), distributed over the threads.
  template <class RunBlock>
  void run_blocks(int blocks, RunBlock&& run_block) {
    // Waking a thread costs some microseconds, so short kernels run on the calling thread. Chunks are large enough to
    // make scheduling cheap, and small enough to balance the load.
    constexpr int kMinParallelBlocks = 8, kChunksPerThread = 8;
    if (pool_->threads() == 1 || blocks < kMinParallelBlocks) {
      for (int b = 0; b < blocks; ++b) run_block(b);
      return;
    }
    const int chunks = std::min(blocks, kChunksPerThread * pool_->threads());
    pool_->run(chunks, [&](int chunk) {
      const int last = static_cast<int>(static_cast<long>(blocks) * (chunk + 1) / chunks);
      for (int b = static_cast<int>(static_cast<long>(blocks) * chunk / chunks); b < last; ++b) run_block(b);
    });
  }
  /// Calls kernel(first) ... kernel(last - 1), for eight vertices of one mesh at once if an AVX2 kernel is available.
  template <class Kernel>
  void run_range(const Kernel& kernel, int first, int last) const {
    int i = first;
    if constexpr (RunsInEights<Kernel>) {
      const RunInEights in_eights = eights_ != nullptr ? slot(*eights_, std::type_identity<Kernel>{}) : nullptr;
      if constexpr (std::is_same_v<Kernel, BlockMotion>) {
        if (in_eights != nullptr) return in_eights(&kernel, first, last - first);
      } else if (in_eights != nullptr) {
        while (i < last) {
          const MeshConstants& mesh = kernel.v.meshes[kernel.v.neighbours[i].w];
          const int end = std::min(last, mesh.first_vertex + mesh.vertex_count), eights = (end - i) / 8;
          if (eights > 0) in_eights(&kernel, i, eights);
          run_scalar(kernel, i + 8 * eights, end);
          i = end;
        }
        return;
      }
    }
    run_scalar(kernel, i, last);
  }
  template <class Kernel>
  static void run_scalar(const Kernel& kernel, int first, int last) {
    if (first >= last) return;
    const Kernel local = kernel;  // local copy, which stores cannot alias
    for (int i = first; i < last; ++i) {
      if constexpr (requires { Kernel::kLanes; })
        local(i, OneLane{});
      else
        local(i);
    }
  }

  std::unique_ptr<ThreadPool> pool_;
  const EightVertices* eights_;
  std::vector<VertexRange> active_;  ///< blocks of active vertices; empty: all vertices
};

}  // namespace

std::unique_ptr<Engine> make_cpu_engine(int threads, CpuCode code) {
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return std::make_unique<StepEngine<CpuExecutor>>(CpuExecutor(threads, code));
}

}  // namespace simplexseg
