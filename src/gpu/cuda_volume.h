// SPDX-License-Identifier: Apache-2.0
// Volume in device memory. Included only by CUDA sources.
#pragma once
#include <limits>

#include "forces/sampling.h"
#include "gpu/backend.h"
#include "gpu/cuda_memory.h"
#include "image/volume.h"

namespace simplexseg {

/// Volume on the device in its own voxel type: a 3D texture if the texture unit can interpolate the type (8-bit and
/// 16-bit integers, float), the volume fits the size limits of a 3D texture and VolumeSampling is not Linear; otherwise
/// linear memory.
class CudaVolume {
 public:
  explicit CudaVolume(VolumeSampling sampling) : sampling_(sampling) {}

  /// Uploads the volume, unless it is bound already, and sets the pointers of the view. Throws DeviceError if device
  /// memory is too small: without any change if less than the volume is free, else after the previous volume is
  /// released.
  void bind(const Volume& volume, VolumeView& view) {
    if (volume.data() != bound_ || volume.empty()) upload(volume);
    view = {};
    view.voxels = linear_.data();
    view.filtered = filtered_.handle(), view.fetched = fetched_.handle();
    view.texel_scale = scale_;
  }
  /// Calls f with the std::type_identity of the sampler for the bound volume, whose voxel type is `type`.
  template <class F>
  void visit(VoxelType type, F&& f) const;

 private:
  /// Intensity per unit of a normalised texel; 0: the texture unit cannot interpolate the type.
  static float texel_scale(VoxelType type) {
    switch (type) {
      case VoxelType::Int8:
        return 127.0f;
      case VoxelType::UInt8:
        return 255.0f;
      case VoxelType::Int16:
        return 32767.0f;
      case VoxelType::UInt16:
        return 65535.0f;
      case VoxelType::Float32:
        return 1.0f;
      default:
        return 0.0f;
    }
  }
  void upload(const Volume& volume) {
    DeviceMemory::for_current_device()->trim(engine_stream().handle());
    const std::size_t available = device_bytes_free() + uploaded_bytes_;
    if (volume.bytes() > available)
      throw DeviceError("volume",
                        std::to_string(volume.bytes() >> 20) + " MiB do not fit into the " +
                            std::to_string(available >> 20) + " MiB of free device memory",
                        "use --backend cpu or a smaller volume");
    bound_ = nullptr, uploaded_bytes_ = 0;
    filtered_ = Texture(), fetched_ = Texture(), array_ = TexelArray();
    linear_.resize(0);
    if (volume.empty()) return;
    scale_ = texel_scale(volume.type());
    const auto& size = volume.geometry().size;
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "selecting a device");
    check(cudaGetDeviceProperties(&properties, device), "reading the device properties");
    const bool fits = size[0] <= properties.maxTexture3D[0] && size[1] <= properties.maxTexture3D[1] &&
                      size[2] <= properties.maxTexture3D[2];
    if (sampling_ != VolumeSampling::Linear && scale_ != 0.0f && fits)
      upload_as_texture(volume);
    else
      linear_.assign({static_cast<const std::byte*>(volume.data()), volume.bytes()});
    bound_ = volume.data();
    uploaded_bytes_ = volume.bytes();
  }
  void upload_as_texture(const Volume& volume) {
    const int bits = static_cast<int>(8 * bytes_per_voxel(volume.type()));
    const bool is_float = volume.type() == VoxelType::Float32;
    const bool is_signed = volume.type() == VoxelType::Int8 || volume.type() == VoxelType::Int16;
    const auto& size = volume.geometry().size;
    const cudaExtent extent{static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[1]),
                            static_cast<std::size_t>(size[2])};
    cudaChannelFormatKind kind = is_signed ? cudaChannelFormatKindSigned : cudaChannelFormatKindUnsigned;
    if (is_float) kind = cudaChannelFormatKindFloat;
    array_ = TexelArray(cudaCreateChannelDesc(bits, 0, 0, 0, kind), extent);
    cudaMemcpy3DParms copy{};
    const std::size_t row = extent.width * bytes_per_voxel(volume.type());
    copy.srcPtr = make_cudaPitchedPtr(const_cast<void*>(volume.data()), row, extent.width, extent.height);
    copy.dstArray = array_.handle();
    copy.extent = extent;
    copy.kind = cudaMemcpyHostToDevice;
    check(cudaMemcpy3DAsync(&copy, engine_stream().handle()), "upload of the volume");
    engine_stream().wait();
    cudaResourceDesc resource{};
    resource.resType = cudaResourceTypeArray;
    resource.res.array.array = array_.handle();
    cudaTextureDesc reading{};
    for (auto& mode : reading.addressMode) mode = cudaAddressModeClamp;
    reading.readMode = is_float ? cudaReadModeElementType : cudaReadModeNormalizedFloat;
    reading.filterMode = cudaFilterModePoint;
    fetched_ = Texture(resource, reading);
    reading.filterMode = cudaFilterModeLinear;
    filtered_ = Texture(resource, reading);
  }

  VolumeSampling sampling_;
  TexelArray array_;  // declared before the textures that read it, so it is destroyed after them
  Texture filtered_, fetched_;
  DeviceArray<std::byte> linear_;
  float scale_ = 0;
  const void* bound_ = nullptr;
  std::size_t uploaded_bytes_ = 0;
};

template <class F>
void CudaVolume::visit(VoxelType type, F&& f) const {
  if (array_) {
    if (sampling_ == VolumeSampling::Filtered)
      f(std::type_identity<FilteredVoxels>{});
    else
      f(std::type_identity<FetchedVoxels>{});
  } else {
    visit_voxel_type(type, [&]<class T>(std::type_identity<T>) { f(std::type_identity<LinearVoxels<T>>{}); });
  }
}

}  // namespace simplexseg
