// SPDX-License-Identifier: Apache-2.0
// CUDA executor: runs the same kernels as the CPU on one stream and replays runs of steps as graphs
// (docs/adr/0010-cuda-execution.md).
#if __has_include(<GL/gl.h>)
#define SIMPLEXSEG_HAS_GL_INTEROP  // the next header includes GL/gl.h
#include <cuda_gl_interop.h>
#endif
#include <cuda_pipeline_primitives.h>

#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "gpu/backend.h"
#include "gpu/cuda_memory.h"
#include "gpu/cuda_volume.h"
#include "gpu/step_engine.h"

namespace simplexseg {
namespace {

constexpr int kThreads = 128;

/// Number of threads per item of the kernel.
template <class Kernel>
constexpr int lanes_of() {
  if constexpr (requires { Kernel::kLanes; })
    return Kernel::kLanes;
  else
    return 1;
}
/// Size of the shared memory per block of the kernel, bytes.
template <class Kernel>
unsigned shared_bytes(const Kernel& kernel) {
  if constexpr (requires { kernel.scratch; })
    return static_cast<unsigned>(kernel.scratch) * (kThreads / lanes_of<Kernel>()) * sizeof(float);
  else
    return 0;
}
template <class Kernel>
int blocks_for(int n) {
  return static_cast<int>((static_cast<long>(n) * lanes_of<Kernel>() + kThreads - 1) / kThreads);
}

/// Index of the item of a thread. The number of threads may exceed the range of int; the number of items does not.
template <int kLanes>
__host__ __device__ constexpr int item_of(int block, int thread) {
  static_assert(kThreads % kLanes == 0);
  return block * (kThreads / kLanes) + thread / kLanes;
}
static_assert(item_of<32>(2, 40) == (2 * kThreads + 40) / 32);
static_assert(item_of<32>(100'000'000, 127) == 400'000'003, "12.8 billion threads");

template <class Kernel>
__device__ void run_item(const Kernel& kernel, int n, int block, [[maybe_unused]] float* scratch) {
  constexpr int kLanes = lanes_of<Kernel>();
  const int item = item_of<kLanes>(block, static_cast<int>(threadIdx.x));
  if (item >= n) return;
  if constexpr (kLanes == 32) {
    kernel(item, WarpLanes{static_cast<int>(threadIdx.x % 32)});
  } else if constexpr (requires { Kernel::kLanes; }) {
    if constexpr (kLanes == 1) {
      kernel(item, ThreadLane(scratch));
    } else {
      const unsigned in_warp = threadIdx.x % 32u, first = in_warp / kLanes * kLanes;
      kernel(item, GroupLanes<kLanes>{static_cast<int>(in_warp - first), ((1u << kLanes) - 1u) << first,
                                      scratch + threadIdx.x / kLanes * kernel.scratch});
    }
  } else {
    kernel(item);
  }
}

/// Waits for the results of the previous kernel. Launches overlap: blocks start while the last blocks of the previous
/// kernel are still running. An earlier start of all kernels was slower: their blocks occupied resources that the
/// previous kernel needed, and were distributed unevenly.
__device__ void wait_for_earlier_kernels() {
#if __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

/// Lets the next kernel start its blocks. Useful only in kernels with few blocks; others would be slowed down.
__device__ void trigger_next_kernel() {
#if __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}
/// Blocks of a launch: all, or only those that contain active vertices.
struct ActiveBlocks {
  static constexpr int kMaxRuns = 6;
  struct Run {
    int first, end;
  };
  int count = 0;  ///< number of runs of consecutive blocks; 0: all blocks
  Run runs[kMaxRuns];
  __device__ int operator[](unsigned block) const {
    int rank = static_cast<int>(block);
    for (int k = 0; k < count; ++k) {
      const Run run = runs[k];
      if (rank < run.end - run.first) return run.first + rank;
      rank -= run.end - run.first;
    }
    return rank;
  }
  /// Number of blocks to launch. `all`: number of blocks without a restriction.
  int launched(int all) const {
    int sum = 0;
    for (int k = 0; k < count; ++k) sum += runs[k].end - runs[k].first;
    return count != 0 ? sum : all;
  }
  /// Selects the blocks that contain vertices of the sorted ranges. If there are more than kMaxRuns runs, the last run
  /// extends over the others. `block_vertices`: number of vertices per block.
  ActiveBlocks(const std::vector<VertexRange>& ranges, int block_vertices) : runs{} {
    for (const VertexRange& range : ranges) {
      const int from = range.first / block_vertices, to = (range.last - 1) / block_vertices + 1;
      if (count == 0 || (from > runs[count - 1].end && count < kMaxRuns))
        runs[count++] = {from, to};
      else
        runs[count - 1].end = to;
    }
  }
};
template <class Kernel>
__global__ void __launch_bounds__(kThreads, 1)
    launch(const __grid_constant__ Kernel kernel, int n, const __grid_constant__ ActiveBlocks active) {
  extern __shared__ float scratch[];
  wait_for_earlier_kernels();
  run_item(kernel, n, active[blockIdx.x], scratch);
}

/// Block of kCount threads in groups of eight.
template <int kCount>
struct CudaBlock {
  static constexpr int threads = kCount, groups = kCount / 8;
  static constexpr bool kUsesSharedMemory = true;
  int thread, group;
  GroupLanes<8> lanes;
  void* memory;
  __device__ void sync() const { __syncthreads(); }
  __device__ void wait_for_earlier_kernels() const { simplexseg::wait_for_earlier_kernels(); }
  /// Starts an asynchronous copy to shared memory.
  template <class T>
  __device__ void copy(T* to, const T* from) const {
    __pipeline_memcpy_async(to, from, sizeof(T));
  }
  __device__ void wait_for_copies() const {
    __pipeline_commit();
    __pipeline_wait_prior(0);
    __syncthreads();
  }
};
template <class Kernel>
__global__ void __launch_bounds__(Kernel::kBlockThreads, 1) launch_block(const __grid_constant__ Kernel kernel) {
  extern __shared__ float4 memory_of_block[];
  const int thread = static_cast<int>(threadIdx.x);
  const unsigned in_warp = threadIdx.x % 32u;
  kernel(CudaBlock<Kernel::kBlockThreads>{
      thread, thread / 8, {static_cast<int>(in_warp % 8u), 0xffu << in_warp / 8u * 8u, nullptr}, memory_of_block});
}

/// Block of threads that computes the step of a tile.
template <int kCount>
struct TileBlock {
  static constexpr int threads = kCount;
  int thread;
  __device__ void sync() const { __syncthreads(); }
  __device__ void wait_for_earlier_kernels() const { simplexseg::wait_for_earlier_kernels(); }
};
template <class Kernel>
__global__ void __launch_bounds__(Kernel::kThreads)
    launch_tiles(const __grid_constant__ Kernel kernel, const __grid_constant__ ActiveBlocks active) {
  extern __shared__ float4 texels_of_tile[];
  trigger_next_kernel();
  kernel(active[blockIdx.x], TileBlock<Kernel::kThreads>{static_cast<int>(threadIdx.x)},
         reinterpret_cast<Vec4*>(texels_of_tile));
}

/// Runs two independent kernels in one launch: `b` in the first blocks, `a` in the others.
template <class A, class B>
__global__ void __launch_bounds__(kThreads)
    launch_pair(const __grid_constant__ A a, int na, const __grid_constant__ ActiveBlocks active_of_a,
                const __grid_constant__ B b, int nb, int blocks_of_b) {
  extern __shared__ float scratch[];
  const int block = static_cast<int>(blockIdx.x);
  wait_for_earlier_kernels();
  if (block < blocks_of_b)
    run_item(b, nb, block, scratch);
  else
    run_item(a, na, active_of_a[blockIdx.x - static_cast<unsigned>(blocks_of_b)], scratch);
}

__global__ void probe() {}

#ifdef SIMPLEXSEG_HAS_GL_INTEROP
class GlBuffer final : public SharedBuffer {
 public:
  /// Registers the OpenGL buffer. False if the driver cannot share the buffer.
  bool connect(unsigned gl_buffer) {
    const bool connected =
        cudaGraphicsGLRegisterBuffer(&resource_, gl_buffer, cudaGraphicsRegisterFlagsWriteDiscard) == cudaSuccess;
    if (!connected) cudaGetLastError();
    return connected;
  }
  ~GlBuffer() override {
    if (resource_ != nullptr) cudaGraphicsUnregisterResource(resource_);
  }
  void* map(std::size_t needed) {
    const cudaStream_t stream = engine_stream().handle();
    check(cudaGraphicsMapResources(1, &resource_, stream), "mapping an OpenGL buffer");
    void* memory = nullptr;
    std::size_t bytes = 0;
    const cudaError_t error = cudaGraphicsResourceGetMappedPointer(&memory, &bytes, resource_);
    if (error != cudaSuccess || bytes < needed) {
      unmap();
      check(error, "mapping an OpenGL buffer");
      throw Error("drawing", "the OpenGL buffer is too small", "pass a buffer with one element per drawn element");
    }
    return memory;
  }
  void unmap() {
    check(cudaGraphicsUnmapResources(1, &resource_, engine_stream().handle()), "unmapping an OpenGL buffer");
  }

 private:
  cudaGraphicsResource* resource_ = nullptr;
};
#endif

class CudaExecutor {
 public:
  static constexpr const char* name = "cuda";
  template <class T>
  using Array = DeviceArray<T>;
  template <class T>
  using HostVisible = HostVisibleArray<T>;
  template <class T>
  using Shared = DeviceCopy<T>;
  using NeighbourArray = simplexseg::NeighbourArray;
  static constexpr bool kRecords = true, kSumsRings = false;
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
  static constexpr bool kTiles = false;  // textures cannot read shared memory
#else
  static constexpr bool kTiles = true;
#endif
  static constexpr float kCycleCost = 4;  ///< duration of a step with a multigrid cycle, relative to a step without
  using Recording = ExecutableGraph;

  explicit CudaExecutor(VolumeSampling sampling) : volume_(sampling) {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "selecting a device");
    check(cudaGetDeviceProperties(&properties, device), "reading the device properties");
    description_ = properties.name;
    // Launches may overlap only if wait_for_earlier_kernels() was compiled for compute capability 9.0 or higher.
    cudaFuncAttributes attributes{};
    check(cudaFuncGetAttributes(&attributes, probe), "reading kernel attributes");
    overlaps_ = properties.major >= 9 && attributes.ptxVersion >= 90;
  }
  std::string description() const { return description_; }
  NamedRange range(const char* name) const { return NamedRange(name); }

  void bind(const Volume& volume, VolumeView& view) { volume_.bind(volume, view); }
  template <class F>
  void visit_voxels(VoxelType type, F&& f) const {
    volume_.visit(type, f);
  }
  /// Calls f with the number of threads per search: four if there are too few vertices to occupy the device, else one.
  template <class F>
  void visit_width(int n, F&& f) const {
    constexpr int kManyVertices = 150'000;
    int active = active_.empty() ? n : 0;
    for (const VertexRange& range : active_) active += range.last - range.first;
    if (active < kManyVertices)
      f(std::integral_constant<int, 4>{});
    else
      f(std::integral_constant<int, 1>{});
  }
  bool failed(const StepStatus*) const { return false; }  // the host reads the status after the batch
  void wait() { engine_stream().wait(); }
  std::uint64_t bytes_read_back() const { return bytes_downloaded(); }
  std::size_t bytes_free() const { return device_bytes_free(); }

  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    run(kernel, n, {});
  }
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    run(kernel, n, active_);
  }
  void restrict_vertices(std::vector<VertexRange> ranges) { active_ = std::move(ranges); }
  template <class Kernel>
  void run(const Kernel& kernel) {
    start(Kernel::name, 1, Kernel::kBlockThreads, static_cast<unsigned>(kernel.levels.shared_bytes()),
          launch_block<Kernel>, kernel);
  }
  template <class Kernel>
  void run_tiles(const Kernel& kernel) {
    const ActiveBlocks active(active_, kTileVertices);
    start(Kernel::name, active.launched(kernel.tiles.count), Kernel::kThreads,
          static_cast<unsigned>(kernel.shared_bytes()), launch_tiles<Kernel>, kernel, active);
  }
  template <class A, class B>
  void run_concurrently(const A& a, int na, const B& b, int nb) {
    if (na <= 0) return run(b, nb);
    if (nb <= 0) return run_over_vertices(a, na);
    const ActiveBlocks active(active_, kThreads / lanes_of<A>());
    const int blocks_of_b = blocks_for<B>(nb);
    start(A::name, active.launched(blocks_for<A>(na)) + blocks_of_b, kThreads,
          std::max(shared_bytes(a), shared_bytes(b)), launch_pair<A, B>, a, na, active, b, nb, blocks_of_b);
  }

  template <class F>
  ExecutableGraph record(F&& body) {
    check(cudaStreamBeginCapture(engine_stream().handle(), cudaStreamCaptureModeThreadLocal), "recording a graph");
    try {
      body();
    } catch (...) {
      cudaGraph_t graph = nullptr;
      cudaStreamEndCapture(engine_stream().handle(), &graph);
      if (graph != nullptr) cudaGraphDestroy(graph);
      cudaGetLastError();
      throw;
    }
    return ExecutableGraph::end_capture();
  }
  void replay(const ExecutableGraph& graph) { graph.launch(); }

  std::unique_ptr<SharedBuffer> share_buffer([[maybe_unused]] unsigned gl_buffer, std::size_t) {
#ifdef SIMPLEXSEG_HAS_GL_INTEROP
    auto buffer = std::make_unique<GlBuffer>();
    if (buffer->connect(gl_buffer)) return buffer;
#endif
    return nullptr;
  }
  template <class T, class F>
  void draw(DrawTarget<T> target, std::size_t n, DeviceArray<T>& staging, F&& write) {
#ifdef SIMPLEXSEG_HAS_GL_INTEROP
    if (auto* shared = static_cast<GlBuffer*>(target.shared)) {
      T* memory = static_cast<T*>(shared->map(n * sizeof(T)));
      try {
        write(memory);
      } catch (...) {
        shared->unmap();
        throw;
      }
      return shared->unmap();
    }
#endif
    if (target.host.size() < n)
      throw Error("drawing", "the buffer is too small", "pass a buffer with one element per drawn element");
    if (staging.size() < n) staging.resize(n), staging.fill_zero();  // kernels may not write all elements
    write(staging.data());
    staging.download(target.host.first(n));
  }

 private:
  template <class Kernel>
  void run(const Kernel& kernel, int n, const std::vector<VertexRange>& ranges) {
    if (n <= 0) return;
    const ActiveBlocks active(ranges, kThreads / lanes_of<Kernel>());
    start(Kernel::name, active.launched(blocks_for<Kernel>(n)), kThreads, shared_bytes(kernel), launch<Kernel>, kernel,
          n, active);
  }
  template <class... Parameters, class... Arguments>
  void start(const char* what, int blocks, int threads, unsigned shared, void (*kernel)(Parameters...),
             const Arguments&... arguments) {
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(static_cast<unsigned>(blocks));
    config.blockDim = dim3(static_cast<unsigned>(threads));
    config.dynamicSmemBytes = shared;
    config.stream = engine_stream().handle();
    cudaLaunchAttribute overlap{};
    overlap.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    overlap.val.programmaticStreamSerializationAllowed = 1;
    config.attrs = &overlap;
    config.numAttrs = overlaps_ ? 1 : 0;
    allow_shared(reinterpret_cast<const void*>(kernel), shared, what);
    check(cudaLaunchKernelEx(&config, kernel, arguments...), what);
  }

  /// Raises the limit of shared memory per block of a kernel, 48 KiB by default, to at least `bytes`.
  void allow_shared(const void* kernel, unsigned bytes, const char* what) {
    constexpr unsigned kDefaultBytes = 48 * 1024;
    if (bytes <= kDefaultBytes) return;
    static std::mutex mutex;
    static std::map<const void*, unsigned> allowed_bytes;  // of all engines; never lowered
    const std::lock_guard lock(mutex);
    unsigned& allowed = allowed_bytes[kernel];
    if (bytes <= allowed) return;
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)), what);
    allowed = bytes;
  }

  std::string description_;
  std::shared_ptr<const DeviceMemory> memory_ = DeviceMemory::for_current_device();  // shared ownership of the pool
  CudaVolume volume_;
  bool overlaps_ = false;
  std::vector<VertexRange> active_;  ///< ranges of active vertices; empty: all vertices
};

}  // namespace

std::string cuda_unavailable_reason() {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error == cudaSuccess && count > 0) return "";
  cudaGetLastError();
  return "no CUDA device";
}

struct DeviceStream::Impl {
  Stream stream{"simplexseg engine of a thread"};
  Stream* previous = std::exchange(stream_of_thread, &stream);
  ~Impl() {
    stream_of_thread = previous;
    cudaStreamSynchronize(stream.handle());  // other streams may then release memory used here
  }
};
DeviceStream::DeviceStream() {
  if (cuda_unavailable_reason().empty()) impl_ = std::make_unique<Impl>();
}
DeviceStream::~DeviceStream() = default;

std::optional<CudaDevice> cuda_device() {
  if (!cuda_unavailable_reason().empty()) return std::nullopt;
  try {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "selecting a device");
    check(cudaGetDeviceProperties(&properties, device), "reading the device properties");
    return CudaDevice{properties.name, device_bytes_free()};
  } catch (const DeviceError&) {
    return std::nullopt;
  }
}

std::unique_ptr<Engine> make_cuda_engine(VolumeSampling sampling) {
  const std::string reason = cuda_unavailable_reason();
  if (!reason.empty()) throw Error("backend cuda", reason, "use --backend cpu");
  return std::make_unique<StepEngine<CudaExecutor>>(CudaExecutor(sampling));
}

}  // namespace simplexseg
