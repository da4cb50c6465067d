// SPDX-License-Identifier: Apache-2.0
// Owners of CUDA resources: streams, memory, textures, graphs. Included only by CUDA sources.
#pragma once
#include <cuda_runtime.h>
#include <nvtx3/nvToolsExt.h>
#include <nvtx3/nvToolsExtCudaRt.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "forces/step_view.h"

namespace simplexseg {

/// Throws DeviceError if a CUDA call failed; `what` names the operation.
inline void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // clears the error unless it is sticky, so that the next call does not report it
  throw DeviceError(
      std::string("CUDA: ") + what, cudaGetErrorString(error),
      error == cudaErrorMemoryAllocation ? "use fewer or coarser meshes, or --backend cpu" : "use --backend cpu");
}

/// NVTX range: a named time span in a profile.
class NamedRange {
 public:
  explicit NamedRange(const char* name) { nvtxRangePushA(name); }
  ~NamedRange() { nvtxRangePop(); }
  NamedRange(const NamedRange&) = delete;
  NamedRange& operator=(const NamedRange&) = delete;
};

class Stream {
 public:
  explicit Stream(const char* name) {
    check(cudaStreamCreateWithFlags(&handle_, cudaStreamNonBlocking), "creating a stream");
    nvtxNameCudaStreamA(handle_, name);
  }
  ~Stream() {
    cudaStreamDestroy(handle_);
    if (staged_ != nullptr) cudaFreeHost(staged_);
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  cudaStream_t handle() const { return handle_; }
  /// Waits for all work on the stream.
  void wait() {
    const std::scoped_lock lock(mutex_);
    finish();
  }
  /// Copies `bytes` bytes from the host to the device. Up to kStaged bytes are staged in pinned memory and copied
  /// asynchronously, after waiting for the stream if the staging memory is full; larger uploads wait for the stream.
  void upload(void* to, const void* from, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    const bool staged = bytes <= kStaged;
    if (staged) from = std::memcpy(stage(bytes), from, bytes);
    check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, handle_), "upload");
    if (!staged) finish();
  }
  /// Copies `bytes` bytes from the device to the host and waits for the stream.
  void download(void* to, const void* from, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    void* const target = bytes <= kStaged ? stage(bytes) : to;
    check(cudaMemcpyAsync(target, from, bytes, cudaMemcpyDeviceToHost, handle_), "download");
    finish();
    if (target != to) std::memcpy(to, target, bytes);
  }

 private:
  static constexpr std::size_t kStaged = 256 * 1024;
  void finish() {
    check(cudaStreamSynchronize(handle_), "waiting for the device");
    staged_bytes_ = 0;
  }
  void* stage(std::size_t bytes) {
    if (staged_ == nullptr) check(cudaHostAlloc(&staged_, kStaged, cudaHostAllocPortable), "allocating pinned memory");
    if (staged_bytes_ + bytes > kStaged) finish();
    void* const slot = static_cast<std::byte*>(staged_) + staged_bytes_;
    staged_bytes_ += (bytes + 15) / 16 * 16;
    return slot;
  }

  cudaStream_t handle_ = nullptr;
  std::mutex mutex_;
  void* staged_ = nullptr;        ///< pinned staging memory
  std::size_t staged_bytes_ = 0;  ///< bytes in use by pending transfers
};
/// Stream of the current thread (DeviceStream); null: the thread uses the stream that all other threads share.
inline thread_local Stream* stream_of_thread = nullptr;
/// Stream on which the engines of this thread copy and clear arrays and run kernels. The stream must outlive the
/// engines; one thread at a time may use an engine.
inline Stream& engine_stream() {
  if (stream_of_thread) return *stream_of_thread;
  static Stream stream("simplexseg engine");
  return stream;
}
/// Number of bytes that all DeviceArrays of this process have copied to the host.
inline std::atomic<std::uint64_t>& bytes_downloaded() {
  static std::atomic<std::uint64_t> bytes = 0;
  return bytes;
}

/// Memory pool of a device for the arrays of engines and fields: released memory is reused in stream order, without
/// synchronisation. The last owner destroys the pool.
class DeviceMemory {
 public:
  explicit DeviceMemory(int device) {
    cudaMemPoolProps properties{};
    properties.allocType = cudaMemAllocationTypePinned;
    properties.location.type = cudaMemLocationTypeDevice;
    properties.location.id = device;
    check(cudaMemPoolCreate(&pool_, &properties), "creating a memory pool");
    std::uint64_t unlimited = ~0ull;
    check(cudaMemPoolSetAttribute(pool_, cudaMemPoolAttrReleaseThreshold, &unlimited), "creating a memory pool");
  }
  ~DeviceMemory() { cudaMemPoolDestroy(pool_); }
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;
  /// Pool of the current device, shared by all owners.
  static std::shared_ptr<const DeviceMemory> for_current_device() {
    static std::mutex mutex;
    static std::map<int, std::weak_ptr<const DeviceMemory>> pools;
    int device = 0;
    check(cudaGetDevice(&device), "selecting a device");
    const std::scoped_lock lock(mutex);
    std::shared_ptr<const DeviceMemory> memory = pools[device].lock();
    if (!memory) pools[device] = memory = std::make_shared<const DeviceMemory>(device);
    return memory;
  }
  /// Allocates memory in stream order. Throws DeviceError, which names the operation `what`.
  void* allocate(std::size_t bytes, cudaStream_t stream, const char* what) const {
    void* at = nullptr;
    cudaError_t error = cudaMallocFromPoolAsync(&at, bytes, pool_, stream);
    if (error == cudaErrorMemoryAllocation) {  // the pool may be fragmented
      cudaGetLastError();
      trim(stream);
      error = cudaMallocFromPoolAsync(&at, bytes, pool_, stream);
    }
    check(error, what);
    return at;
  }
  /// Waits for the stream and returns unused memory of the pool to the device, for allocations outside the pool.
  void trim(cudaStream_t stream) const {
    check(cudaStreamSynchronize(stream), "waiting for the device");
    check(cudaMemPoolTrimTo(pool_, 0), "releasing memory");
  }
  std::size_t bytes_unused() const {
    std::uint64_t reserved = 0, used = 0;
    check(cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrReservedMemCurrent, &reserved), "reading the free memory");
    check(cudaMemPoolGetAttribute(pool_, cudaMemPoolAttrUsedMemCurrent, &used), "reading the free memory");
    return reserved - used;
  }

 private:
  cudaMemPool_t pool_ = nullptr;
};
/// Free memory of the current device, including unused memory of its pool, bytes.
inline std::size_t device_bytes_free() {
  std::size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total), "reading the free memory");
  return free + DeviceMemory::for_current_device()->bytes_unused();
}

/// Owner of a texture object. The memory that the texture reads must outlive this object.
class Texture {
 public:
  Texture() = default;
  Texture(const cudaResourceDesc& resource, const cudaTextureDesc& reading) {
    check(cudaCreateTextureObject(&handle_, &resource, &reading, nullptr), "creating a texture");
  }
  ~Texture() {
    if (handle_ != 0) cudaDestroyTextureObject(handle_);
  }
  Texture(Texture&& other) noexcept { std::swap(handle_, other.handle_); }
  Texture& operator=(Texture&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  unsigned long long handle() const { return handle_; }

 private:
  cudaTextureObject_t handle_ = 0;
};

/// Array in linear memory of the device.
template <class T>
class DeviceArray {
 public:
  DeviceArray() = default;
  ~DeviceArray() { release(); }
  DeviceArray(DeviceArray&& other) noexcept { swap(other); }
  DeviceArray& operator=(DeviceArray&& other) noexcept {
    swap(other);
    return *this;
  }
  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }
  Texels<T> texels() const {
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
    return {data_, texture_.handle()};
#else
    return {data_};
#endif
  }
  void resize(std::size_t n) {
    if (n == size_) return;
    release();
    if (n == 0) return;
    if (!memory_) memory_ = DeviceMemory::for_current_device();
    data_ = static_cast<T*>(memory_->allocate(n * sizeof(T), engine_stream().handle(), "allocating mesh arrays"));
    size_ = n;
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
    if constexpr (sizeof(T) == sizeof(float4)) {
      cudaResourceDesc resource{};
      resource.resType = cudaResourceTypeLinear;
      resource.res.linear = {data_, cudaCreateChannelDesc<float4>(), bytes()};
      cudaTextureDesc reading{};
      reading.readMode = cudaReadModeElementType;
      texture_ = Texture(resource, reading);
    }
#endif
  }
  void upload(std::span<const T> from, std::size_t first = 0) {
    if (from.empty()) return;
    engine_stream().upload(data_ + first, from.data(), from.size_bytes());
  }
  void assign(std::span<const T> from) { resize(from.size()), upload(from); }
  /// Resizes the array and uploads asynchronously. `from` must stay unchanged until the copy on the stream is complete.
  void assign_async(std::span<const T> from) {
    resize(from.size());
    if (from.empty()) return;
    check(cudaMemcpyAsync(data_, from.data(), from.size_bytes(), cudaMemcpyHostToDevice, engine_stream().handle()),
          "upload");
  }
  void download(std::span<T> to, std::size_t first = 0) {
    if (to.empty()) return;
    engine_stream().download(to.data(), data_ + first, to.size_bytes());
    bytes_downloaded() += to.size_bytes();
  }
  void fill_zero() { fill(0); }
  void fill_ones() { fill(0xff); }

 private:
  void fill(int byte) {
    if (size_ != 0) check(cudaMemsetAsync(data_, byte, bytes(), engine_stream().handle()), "clearing an array");
  }
  void release() {
    if (data_ == nullptr) return;
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
    cudaStreamSynchronize(engine_stream().handle());
    texture_ = Texture();
#endif
    cudaFreeAsync(data_, engine_stream().handle());
    data_ = nullptr, size_ = 0;
  }
  void swap(DeviceArray& other) noexcept {
    std::swap(memory_, other.memory_), std::swap(data_, other.data_), std::swap(size_, other.size_);
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
    std::swap(texture_, other.texture_);
#endif
  }
  std::shared_ptr<const DeviceMemory> memory_;
  T* data_ = nullptr;
  std::size_t size_ = 0;
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
  Texture texture_;
#endif
};

/// CUDA array (the memory layout of textures) of up to three dimensions.
class TexelArray {
 public:
  TexelArray() = default;
  TexelArray(const cudaChannelFormatDesc& texel, cudaExtent size) {
    check(cudaMalloc3DArray(&handle_, &texel, size), "allocating a texture");
  }
  ~TexelArray() {
    if (handle_ == nullptr) return;
    cudaStreamSynchronize(engine_stream().handle());
    cudaFreeArray(handle_);
  }
  TexelArray(TexelArray&& other) noexcept { std::swap(handle_, other.handle_); }
  TexelArray& operator=(TexelArray&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  cudaArray_t handle() const { return handle_; }
  explicit operator bool() const { return handle_ != nullptr; }

 private:
  cudaArray_t handle_ = nullptr;
};

/// Device memory of NeighbourTexels.
class NeighbourArray {
 public:
  std::size_t size() const { return size_; }
#ifdef SIMPLEXSEG_TEXTURE_ARRAYS
  std::size_t bytes() const { return size_ * sizeof(Int4); }
  NeighbourTexels texels() const { return {nullptr, nullptr, texture_.handle()}; }
  void assign(std::span<const Int4> from) {
    texture_ = Texture();
    array_ = TexelArray();
    size_ = from.size();
    if (size_ == 0) return;
    constexpr std::size_t kWidth = NeighbourTexels::kWidth;
    const std::size_t rows = size_ / kWidth, remainder = size_ % kWidth;
    array_ = TexelArray(cudaCreateChannelDesc<int4>(), cudaExtent{kWidth, rows + (remainder != 0 ? 1 : 0), 0});
    const std::size_t row = kWidth * sizeof(Int4);
    if (rows != 0)
      check(cudaMemcpy2DToArray(array_.handle(), 0, 0, from.data(), row, row, rows, cudaMemcpyHostToDevice), "upload");
    if (remainder != 0)
      check(cudaMemcpy2DToArray(array_.handle(), 0, rows, from.data() + rows * kWidth, row, remainder * sizeof(Int4), 1,
                                cudaMemcpyHostToDevice),
            "upload");
    cudaResourceDesc resource{};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array_.handle();
    cudaTextureDesc reading{};
    reading.readMode = cudaReadModeElementType;
    texture_ = Texture(resource, reading);
  }

 private:
  TexelArray array_;
  Texture texture_;
  std::size_t size_ = 0;
#else
  std::size_t bytes() const { return wide_.bytes() + packed_.bytes(); }
  NeighbourTexels texels() const { return {wide_.data(), packed_.data()}; }
  void assign(std::span<const Int4> from) {
    size_ = from.size();
    std::vector<PackedNeighbours> packed(size_);
    bool fits = true;
    for (std::size_t i = 0; i < size_ && fits; ++i) {
      auto pack = [&](int j) {
        const long difference = j - static_cast<long>(i);
        fits = fits && difference >= -32768 && difference <= 32767;
        return static_cast<std::int16_t>(difference);
      };
      const Int4& nb = from[i];
      packed[i] = {pack(nb.x), pack(nb.y), pack(nb.z), static_cast<std::uint16_t>(nb.w)};
      fits = fits && nb.w <= 65535;
    }
    wide_.resize(0), packed_.resize(0);
    if (fits)
      packed_.assign(packed);
    else
      wide_.assign(from);
  }

 private:
  DeviceArray<Int4> wide_;
  DeviceArray<PackedNeighbours> packed_;
  std::size_t size_ = 0;
#endif
};

/// Array in pinned host memory that kernels write, so that the host reads the few bytes of a result without a copy.
template <class T>
class HostVisibleArray {
 public:
  HostVisibleArray() = default;
  ~HostVisibleArray() { release(); }
  HostVisibleArray(const HostVisibleArray&) = delete;
  HostVisibleArray& operator=(const HostVisibleArray&) = delete;
  HostVisibleArray(HostVisibleArray&& other) noexcept { swap(other); }
  HostVisibleArray& operator=(HostVisibleArray&& other) noexcept {
    swap(other);
    return *this;
  }
  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  void resize(std::size_t n) {
    if (n == size_) return;
    release();
    if (n == 0) return;
    void* memory = nullptr;
    check(cudaHostAlloc(&memory, n * sizeof(T), cudaHostAllocMapped | cudaHostAllocPortable),
          "allocating pinned memory");
    data_ = static_cast<T*>(memory), size_ = n;
  }

 private:
  void release() {
    if (data_ == nullptr) return;
    cudaStreamSynchronize(engine_stream().handle());
    cudaFreeHost(data_);
    data_ = nullptr, size_ = 0;
  }
  void swap(HostVisibleArray& other) noexcept { std::swap(data_, other.data_), std::swap(size_, other.size_); }
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Copy of values in device memory.
template <class T>
class DeviceCopy : public DeviceArray<T> {
 public:
  void share(std::span<const T> values) { this->assign(values); }
};

/// Executable CUDA graph: a recorded sequence of launches.
class ExecutableGraph {
 public:
  ExecutableGraph() = default;
  /// Ends the capture on engine_stream() and instantiates the captured graph.
  static ExecutableGraph end_capture() {
    cudaGraph_t graph = nullptr;
    check(cudaStreamEndCapture(engine_stream().handle(), &graph), "recording a graph");
    ExecutableGraph result;
    const cudaError_t error = cudaGraphInstantiate(&result.handle_, graph, 0);
    cudaGraphDestroy(graph);
    check(error, "instantiating a graph");
    return result;
  }
  ~ExecutableGraph() {
    if (handle_ == nullptr) return;
    cudaStreamSynchronize(engine_stream().handle());
    cudaGraphExecDestroy(handle_);
  }
  ExecutableGraph(ExecutableGraph&& other) noexcept { std::swap(handle_, other.handle_); }
  ExecutableGraph& operator=(ExecutableGraph&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  void launch() const { check(cudaGraphLaunch(handle_, engine_stream().handle()), "launching a graph"); }

 private:
  cudaGraphExec_t handle_ = nullptr;
};

}  // namespace simplexseg
