// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "image/volume.h"
#include "io/source/dicom_slice.h"

namespace simplexseg {

class WorkerRequest;

/// Returns the stored type if the pixels are not rescaled. Otherwise returns the smallest integer type for all rescaled
/// values that the stored bits can represent, or a floating-point type if slope or intercept is not an integer or no
/// integer type fits. Exception: 16-bit pixels with slope 1 and an intercept, e.g. -1024 in CT, use Int16, although
/// some values may not fit; DicomFrames::read() then returns false.
VoxelType voxel_type_of(const DicomSlice& slice);

/// Sequential reader of the pixels of slices with one sample per pixel. Uncompressed slices are read individually. GDCM
/// decodes each compressed file as a whole in a worker process, because its codecs can crash on damaged data.
class DicomFrames {
 public:
  /// `slices`: the slices for which read() will be called, in that order.
  explicit DicomFrames(const std::vector<DicomSlice>& slices);
  ~DicomFrames();
  /// Writes the rescaled values of a slice to `to` as `type`. Returns false when a rescaled value does not fit and was
  /// clamped; the slice can then be read again as another type. Throws Error when the pixels cannot be decoded, do not
  /// match the header or are truncated.
  bool read(const DicomSlice& slice, VoxelType type, void* to);

 private:
  void open(const DicomSlice& slice);
  void receive_decoded(const DicomSlice& slice);
  const std::byte* stored(const DicomSlice& slice);

  std::unique_ptr<WorkerRequest> decoder_;  ///< decoder of compressed files; null when there are none
  std::size_t compressed_left_ = 0;         ///< number of files that the decoder has not yet sent completely
  std::filesystem::path file_;              ///< currently open file
  DicomPixels pixels_;
  VoxelType stored_type_ = VoxelType::UInt8;
  std::size_t frame_bytes_ = 0;
  std::ifstream stream_;           ///< uncompressed pixels
  std::vector<std::byte> buffer_;  ///< one uncompressed frame, or all frames of a compressed file
};

/// Returns the memory that DicomFrames needs for a file with these pixels, including that of the decoder, bytes.
std::size_t buffer_bytes(const DicomPixels& pixels);

}  // namespace simplexseg
