// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <thread>

#include "core/thread_pool.h"
#include "gpu/backend.h"
#include "gpu/step_engine.h"

namespace simplexseg {
namespace {

/// 64-byte aligned, uninitialised until written.
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
    const std::size_t bytes = (n * sizeof(T) + 63) / 64 * 64;
    data_.reset(static_cast<T*>(std::aligned_alloc(64, bytes)));
    if (!data_)
      throw Error("mesh arrays", std::to_string(bytes >> 20) + " MiB of memory could not be had",
                  "use fewer or coarser meshes");
    size_ = n;
  }
  void upload(std::span<const T> from, std::size_t first = 0) {
    std::copy(from.begin(), from.end(), data_.get() + first);
  }
  void assign(std::span<const T> from) { resize(from.size()), upload(from); }
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

/// Runs kernels over blocks of fixed size, so that a vertex meets the same instructions on any number of threads.
class CpuExecutor {
 public:
  static constexpr const char* name = "cpu";
  template <class T>
  using Array = HostArray<T>;
  template <class T>
  using HostVisible = HostArray<T>;
  using NeighbourArray = HostArray<Int4>;
  static constexpr bool kRecords = false;
  static constexpr float kCycleCost = 2.4f;  ///< of a step with a multigrid cycle, in steps without
  struct Recording {};
  explicit CpuExecutor(int threads) : pool_(std::make_unique<ThreadPool>(threads)) {}
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
  std::size_t bytes_free() const { return std::numeric_limits<std::size_t>::max(); }  // the system swaps, and says so
  template <class T, class F>
  void draw(DrawTarget<T> target, std::size_t n, HostArray<T>&, F&& write) {
    if (target.host.size() < n)
      throw Error("drawing", "the buffer is too small", "give one of the size of what is drawn");
    write(target.host.data());
  }

  template <class A, class B>
  void run_together(const A& a, int na, const B& b, int nb) {
    run(b, nb);
    run(a, na);
  }
  template <class Kernel>
  void run(const Kernel& kernel) {
    kernel(OneGroup{});
  }
  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    constexpr int kBlock = 256;
    const int blocks = (n + kBlock - 1) / kBlock;
    auto run_block = [&](int b) {
      const Kernel local = kernel;  // its own copy: the compiler need not fear that stores change the view
      const int last = std::min(n, (b + 1) * kBlock);
      for (int i = b * kBlock; i < last; ++i) {
        if constexpr (requires { Kernel::kLanes; })
          local(i, OneLane{});
        else
          local(i);
      }
    };
    // Waking a thread costs some microseconds: a kernel is shared out only where it takes much longer. A chunk is large
    // enough that taking it costs nothing, and small enough that all threads end together.
    constexpr int kBlocksWorthSharing = 8, kChunksPerThread = 8;
    if (pool_->threads() == 1 || blocks < kBlocksWorthSharing) {
      for (int b = 0; b < blocks; ++b) run_block(b);
      return;
    }
    const int chunks = std::min(blocks, kChunksPerThread * pool_->threads());
    pool_->run(chunks, [&](int chunk) {
      const int last = static_cast<int>(static_cast<long>(blocks) * (chunk + 1) / chunks);
      for (int b = static_cast<int>(static_cast<long>(blocks) * chunk / chunks); b < last; ++b) run_block(b);
    });
  }

 private:
  std::unique_ptr<ThreadPool> pool_;
};

}  // namespace

std::unique_ptr<Engine> make_cpu_engine(int threads) {
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return std::make_unique<StepEngine<CpuExecutor>>(CpuExecutor(threads));
}

}  // namespace simplexseg
