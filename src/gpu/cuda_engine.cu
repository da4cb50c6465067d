// SPDX-License-Identifier: Apache-2.0
// The CUDA executor: the same kernels as the CPU's, a launch each, on one stream of its own.
#include <cuda_runtime.h>

#include <memory>

#include "gpu/backend.h"
#include "gpu/step_engine.h"

namespace simplexseg {
namespace {

void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  cudaGetLastError();      // what is not sticky must not be reported again by the next call
  throw Error(std::string("CUDA: ") + what, cudaGetErrorString(error),
              error == cudaErrorMemoryAllocation ? "use fewer or coarser meshes, or --backend cpu" : "use --backend cpu");
}

struct Stream {
  cudaStream_t handle = nullptr;
  Stream() { check(cudaStreamCreateWithFlags(&handle, cudaStreamNonBlocking), "creating a stream"); }
  ~Stream() { cudaStreamDestroy(handle); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  void wait() { check(cudaStreamSynchronize(handle), "waiting for the device"); }
};
/// All arrays of the engine copy and clear on this stream, in order with its kernels; it outlives them.
Stream& engine_stream() {
  static Stream stream;
  return stream;
}

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
  void resize(std::size_t n) {
    if (n == size_) return;
    release();
    if (n == 0) return;
    check(cudaMalloc(&data_, n * sizeof(T)), "allocating mesh arrays");
    size_ = n;
  }
  void upload(std::span<const T> from) {
    if (from.empty()) return;
    check(cudaMemcpyAsync(data_, from.data(), from.size_bytes(), cudaMemcpyHostToDevice, engine_stream().handle), "upload");
    engine_stream().wait();
  }
  void assign(std::span<const T> from) { resize(from.size()), upload(from); }
  void download(std::span<T> to, std::size_t first = 0) {
    if (to.empty()) return;
    check(cudaMemcpyAsync(to.data(), data_ + first, to.size_bytes(), cudaMemcpyDeviceToHost, engine_stream().handle), "download");
    engine_stream().wait();
  }
  void fill_zero() { fill(0); }
  void fill_ones() { fill(0xff); }

 private:
  void fill(int byte) {
    if (size_ != 0) check(cudaMemsetAsync(data_, byte, bytes(), engine_stream().handle), "clearing an array");
  }
  void release() {
    if (data_ == nullptr) return;
    cudaStreamSynchronize(engine_stream().handle);
    cudaFree(data_);
    data_ = nullptr, size_ = 0;
  }
  void swap(DeviceArray& other) noexcept { std::swap(data_, other.data_), std::swap(size_, other.size_); }
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

template <class Kernel>
__global__ void launch(const Kernel kernel, int n, const StepStatus* status, unsigned long long step) {
  if (status != nullptr && (status->failure >> 40) < step) return;     // a step failed: what came after it is not done
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < n) kernel(i);
}

class CudaExecutor {
 public:
  static constexpr const char* name = "cuda";
  template <class T>
  using Array = DeviceArray<T>;

  CudaExecutor() {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "choosing a device");
    check(cudaGetDeviceProperties(&properties, device), "asking the device");
    description_ = properties.name;
  }
  std::string description() const { return description_; }

  void bind(const Volume& volume, VolumeView& view) {
    if (volume.data() == bound_) {
      view.voxels = voxels_.data();
      return;
    }
    voxels_.resize(0);
    bound_ = nullptr;
    std::size_t free = 0, total = 0;
    check(cudaMemGetInfo(&free, &total), "asking for free memory");
    if (volume.bytes() > free)
      throw Error("volume", std::to_string(volume.bytes() >> 20) + " MiB do not fit into the " + std::to_string(free >> 20) + " MiB that are free on the device",
                  "use --backend cpu or a smaller volume");
    if (!volume.empty()) voxels_.assign({static_cast<const std::byte*>(volume.data()), volume.bytes()});
    view.voxels = voxels_.data();
    bound_ = volume.data();
  }
  void begin_step(const StepStatus* status, unsigned long long step) { status_ = status, step_ = step; }
  bool failed(const StepStatus*) const { return false; }      // known to the kernels; the host learns it after the batch

  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    if (n <= 0) return;
    constexpr int kThreads = 128;
    launch<<<(n + kThreads - 1) / kThreads, kThreads, 0, engine_stream().handle>>>(kernel, n, status_, step_);
    check(cudaGetLastError(), Kernel::name);
  }

 private:
  std::string description_;
  DeviceArray<std::byte> voxels_;
  const void* bound_ = nullptr;
  const StepStatus* status_ = nullptr;
  unsigned long long step_ = 0;
};

}  // namespace

std::string why_no_cuda() {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error == cudaSuccess && count > 0) return "";
  cudaGetLastError();
  return "no CUDA device";
}

std::unique_ptr<Engine> make_cuda_engine() {
  const std::string reason = why_no_cuda();
  if (!reason.empty()) throw Error("backend cuda", reason, "use --backend cpu");
  return std::make_unique<StepEngine<CudaExecutor>>(CudaExecutor());
}

}  // namespace simplexseg
