// SPDX-License-Identifier: Apache-2.0
// The CUDA executor: the same kernels as the CPU's on one stream, runs of steps replayed as graphs
// (docs/adr/0010-cuda-execution.md).
#if __has_include(<GL/gl.h>)
#define SIMPLEXSEG_HAS_GL_INTEROP  // what the header below stands on
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

/// Threads that one item of the kernel takes.
template <class Kernel>
constexpr int lanes_of() {
  if constexpr (requires { Kernel::kLanes; })
    return Kernel::kLanes;
  else
    return 1;
}
/// Bytes of shared memory that one block of the kernel takes.
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

/// The item that a thread works on. Threads may be more than an int counts, items are not.
template <int kLanes>
__host__ __device__ constexpr int item_of(int block, int thread) {
  static_assert(kThreads % kLanes == 0);
  return block * (kThreads / kLanes) + thread / kLanes;
}
static_assert(item_of<32>(2, 40) == (2 * kThreads + 40) / 32);
static_assert(item_of<32>(100'000'000, 127) == 400'000'003, "12.8 billion threads");

template <class Kernel>
__device__ void work(const Kernel& kernel, int n, int block, [[maybe_unused]] float* scratch) {
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

/// Launches overlap: a kernel's blocks come to the device while the last ones of the kernel before it end, and wait
/// here for its results. Letting them come earlier takes room from that kernel and spreads them unevenly: it was
/// slower.
__device__ void wait_for_earlier_kernels() {
#if __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

/// Lets the blocks of the next kernel come now, and make ready. Where they are few: many would be in the way.
__device__ void let_next_kernel_come() {
#if __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}
/// The blocks that a launch has, of those that all vertices would take: some are left out.
struct ActingBlocks {
  static constexpr int kMost = 6;
  struct Run {
    int first, end;
  };
  int count = 0;  ///< of runs of blocks that follow each other; 0: all are there
  Run runs[kMost];
  __device__ int operator[](unsigned block) const {
    int left = static_cast<int>(block);
    for (int k = 0; k < count; ++k) {
      const Run run = runs[k];
      if (left < run.end - run.first) return run.first + left;
      left -= run.end - run.first;
    }
    return left;
  }
  int of(int all) const {
    int sum = 0;
    for (int k = 0; k < count; ++k) sum += runs[k].end - runs[k].first;
    return count != 0 ? sum : all;
  }
  /// Those of some vertices, in order; more of them where there are too many runs.
  ActingBlocks(const std::vector<VertexRange>& ranges, int vertices_of_block) : runs{} {
    for (const VertexRange& range : ranges) {
      const int from = range.first / vertices_of_block, to = (range.last - 1) / vertices_of_block + 1;
      if (count == 0 || (from > runs[count - 1].end && count < kMost))
        runs[count++] = {from, to};
      else
        runs[count - 1].end = to;
    }
  }
};
template <class Kernel>
__global__ void __launch_bounds__(kThreads, 1)
    launch(const __grid_constant__ Kernel kernel, int n, const __grid_constant__ ActingBlocks acting) {
  extern __shared__ float scratch[];
  wait_for_earlier_kernels();
  work(kernel, n, acting[blockIdx.x], scratch);
}

/// A block of kCount threads, eight to a group.
template <int kCount>
struct BlockTeam {
  static constexpr int threads = kCount, groups = kCount / 8;
  static constexpr bool kOwnMemory = true;
  int thread, group;
  GroupLanes<8> lanes;
  void* memory;
  __device__ void sync() const { __syncthreads(); }
  __device__ void wait_for_earlier_kernels() const { simplexseg::wait_for_earlier_kernels(); }
  /// All copies are under way together.
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
__global__ void __launch_bounds__(Kernel::kTeam, 1) launch_team(const __grid_constant__ Kernel kernel) {
  extern __shared__ float4 memory_of_team[];
  const int thread = static_cast<int>(threadIdx.x);
  const unsigned in_warp = threadIdx.x % 32u;
  kernel(BlockTeam<Kernel::kTeam>{
      thread, thread / 8, {static_cast<int>(in_warp % 8u), 0xffu << in_warp / 8u * 8u, nullptr}, memory_of_team});
}

/// The threads that take the step of a tile.
template <int kCount>
struct TileTeam {
  static constexpr int threads = kCount;
  int thread;
  __device__ void sync() const { __syncthreads(); }
  __device__ void wait_for_earlier_steps() const { wait_for_earlier_kernels(); }
};
template <class Kernel>
__global__ void __launch_bounds__(Kernel::kThreads)
    launch_tiles(const __grid_constant__ Kernel kernel, const __grid_constant__ ActingBlocks acting) {
  extern __shared__ float4 texels_of_tile[];
  let_next_kernel_come();
  kernel(acting[blockIdx.x], TileTeam<Kernel::kThreads>{static_cast<int>(threadIdx.x)},
         reinterpret_cast<Vec4*>(texels_of_tile));
}

/// Two kernels that do not depend on each other, the second one in the first blocks.
template <class A, class B>
__global__ void __launch_bounds__(kThreads)
    launch_together(const __grid_constant__ A a, int na, const __grid_constant__ ActingBlocks acting_of_a,
                    const __grid_constant__ B b, int nb, int blocks_of_b) {
  extern __shared__ float scratch[];
  const int block = static_cast<int>(blockIdx.x);
  wait_for_earlier_kernels();
  if (block < blocks_of_b)
    work(b, nb, block, scratch);
  else
    work(a, na, acting_of_a[blockIdx.x - static_cast<unsigned>(blocks_of_b)], scratch);
}

__global__ void probe() {}

#ifdef SIMPLEXSEG_HAS_GL_INTEROP
class GlBuffer final : public SharedBuffer {
 public:
  /// False when the driver cannot share the buffer.
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
      throw Error("drawing", "the OpenGL buffer is too small", "give one of the size of what is drawn");
    }
    return memory;
  }
  void unmap() {
    check(cudaGraphicsUnmapResources(1, &resource_, engine_stream().handle()), "giving an OpenGL buffer back");
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
  using NeighbourArray = simplexseg::NeighbourArray;
  static constexpr bool kRecords = true, kSumsRings = false;
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
  static constexpr bool kTiles = false;  // a texture is not of a block's own memory
#else
  static constexpr bool kTiles = true;
#endif
  static constexpr float kCycleCost = 4;  ///< of a step with a multigrid cycle, in steps without
  using Recording = ExecutableGraph;

  explicit CudaExecutor(VolumeSampling sampling) : volume_(sampling) {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "choosing a device");
    check(cudaGetDeviceProperties(&properties, device), "asking the device");
    description_ = properties.name;
    // Waiting inside the kernels must have been compiled in.
    cudaFuncAttributes attributes{};
    check(cudaFuncGetAttributes(&attributes, probe), "asking a kernel");
    overlaps_ = properties.major >= 9 && attributes.ptxVersion >= 90;
  }
  std::string description() const { return description_; }
  NamedRange range(const char* name) const { return NamedRange(name); }

  void bind(const Volume& volume, VolumeView& view) { volume_.bind(volume, view); }
  template <class F>
  void visit_voxels(VoxelType type, F&& f) const {
    volume_.visit(type, f);
  }
  /// Few vertices leave most of the device idle: then several threads share one search, which ends sooner.
  template <class F>
  void visit_width(int n, F&& f) const {
    constexpr int kManyVertices = 150'000;
    int acting = acting_.empty() ? n : 0;
    for (const VertexRange& range : acting_) acting += range.last - range.first;
    if (acting < kManyVertices)
      f(std::integral_constant<int, 4>{});
    else
      f(std::integral_constant<int, 1>{});
  }
  bool failed(const StepStatus*) const { return false; }  // known to the kernels; the host learns it after the batch
  void wait() { engine_stream().wait(); }
  std::uint64_t bytes_read_back() const { return bytes_downloaded(); }
  std::size_t bytes_free() const { return device_bytes_free(); }

  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    run(kernel, n, {});
  }
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    run(kernel, n, acting_);
  }
  void leave_to(std::vector<VertexRange> ranges) { acting_ = std::move(ranges); }
  template <class Kernel>
  void run(const Kernel& kernel) {
    start(Kernel::name, 1, Kernel::kTeam, static_cast<unsigned>(kernel.levels.shared_bytes()), launch_team<Kernel>,
          kernel);
  }
  template <class Kernel>
  void run_tiles(const Kernel& kernel) {
    const ActingBlocks acting(acting_, kTileVertices);
    start(Kernel::name, acting.of(kernel.tiles.count), Kernel::kThreads, static_cast<unsigned>(kernel.shared_bytes()),
          launch_tiles<Kernel>, kernel, acting);
  }
  template <class A, class B>
  void run_together(const A& a, int na, const B& b, int nb) {
    if (na <= 0) return run(b, nb);
    if (nb <= 0) return run_over_vertices(a, na);
    const ActingBlocks acting(acting_, kThreads / lanes_of<A>());
    const int blocks_of_b = blocks_for<B>(nb);
    start(A::name, acting.of(blocks_for<A>(na)) + blocks_of_b, kThreads, std::max(shared_bytes(a), shared_bytes(b)),
          launch_together<A, B>, a, na, acting, b, nb, blocks_of_b);
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
      throw Error("drawing", "the buffer is too small", "give one of the size of what is drawn");
    if (staging.size() < n) staging.resize(n), staging.fill_zero();  // all of it is read back, whatever is written
    write(staging.data());
    staging.download(target.host.first(n));
  }

 private:
  template <class Kernel>
  void run(const Kernel& kernel, int n, const std::vector<VertexRange>& ranges) {
    if (n <= 0) return;
    const ActingBlocks acting(ranges, kThreads / lanes_of<Kernel>());
    start(Kernel::name, acting.of(blocks_for<Kernel>(n)), kThreads, shared_bytes(kernel), launch<Kernel>, kernel, n,
          acting);
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

  /// A kernel gets more than 48 KB of shared memory for a block only where it was said before that it may.
  void allow_shared(const void* kernel, unsigned bytes, const char* what) {
    constexpr unsigned kForAll = 48 * 1024;
    if (bytes <= kForAll) return;
    static std::mutex mutex;
    static std::map<const void*, unsigned> allowed_bytes;  // what one engine may, another must not take back
    const std::lock_guard lock(mutex);
    unsigned& allowed = allowed_bytes[kernel];
    if (bytes <= allowed) return;
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)), what);
    allowed = bytes;
  }

  std::string description_;
  std::shared_ptr<const DeviceMemory> memory_ = DeviceMemory::of_device();  // what arrays give back stays
  CudaVolume volume_;
  bool overlaps_ = false;
  std::vector<VertexRange> acting_;  ///< empty: all vertices are
};

}  // namespace

std::string why_no_cuda() {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error == cudaSuccess && count > 0) return "";
  cudaGetLastError();
  return "no CUDA device";
}

struct DeviceStream::Own {
  Stream stream{"simplexseg engine of a thread"};
  Stream* before = std::exchange(stream_of_thread, &stream);
  ~Own() {
    stream_of_thread = before;
    cudaStreamSynchronize(stream.handle());  // what it still uses may be given back on another stream now
  }
};
DeviceStream::DeviceStream() {
  if (why_no_cuda().empty()) own_ = std::make_unique<Own>();
}
DeviceStream::~DeviceStream() = default;

std::optional<CudaDevice> cuda_device() {
  if (!why_no_cuda().empty()) return std::nullopt;
  try {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "choosing a device");
    check(cudaGetDeviceProperties(&properties, device), "asking the device");
    return CudaDevice{properties.name, device_bytes_free()};
  } catch (const DeviceError&) {
    return std::nullopt;
  }
}

std::unique_ptr<Engine> make_cuda_engine(VolumeSampling sampling) {
  const std::string reason = why_no_cuda();
  if (!reason.empty()) throw Error("backend cuda", reason, "use --backend cpu");
  return std::make_unique<StepEngine<CudaExecutor>>(CudaExecutor(sampling));
}

}  // namespace simplexseg
