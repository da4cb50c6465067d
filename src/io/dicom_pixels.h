// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <fstream>
#include <vector>

#include "image/volume.h"
#include "io/dicom_slice.h"

namespace simplexseg {

/// The smallest type that holds every value which the slice's bits can say once it is rescaled; the stored type where
/// it is not. But Int16 where 16 bits are shifted alone, as by the intercept -1024 of CT: values beyond it are
/// possible, and DicomFrames::read() tells of them.
VoxelType voxel_type_of(const DicomSlice& slice);

/// The pixels of one file of one sample a pixel, frame by frame. What is not compressed is read as it is asked for;
/// else GDCM decodes the whole file at once.
class DicomFrames {
 public:
  /// The file is that of the slice. Throws Error when the pixels cannot be decoded, or are not what the header says.
  explicit DicomFrames(const DicomSlice& slice);
  /// Writes the values of a frame of the file, rescaled, as `type` to `to`; false where one lies beyond it, which is
  /// then its least or most. Throws Error when the file ends early.
  bool read(const DicomSlice& slice, VoxelType type, void* to);

 private:
  const std::byte* stored(const DicomSlice& slice);

  DicomPixels pixels_;
  VoxelType stored_type_;
  std::size_t frame_bytes_ = 0;
  std::ifstream stream_;           ///< for plain pixels
  std::vector<std::byte> buffer_;  ///< one frame of plain pixels, else all
};

/// Bytes of memory that a DicomFrames of the file takes.
std::size_t buffer_bytes(const DicomPixels& pixels);

}  // namespace simplexseg
