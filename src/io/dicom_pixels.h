// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "image/volume.h"
#include "io/dicom_slice.h"

namespace simplexseg {

class ChildProcess;

/// The smallest type that holds every value which the slice's bits can say once it is rescaled; the stored type where
/// it is not. But Int16 where 16 bits are shifted alone, as by the intercept -1024 of CT: values beyond it are
/// possible, and DicomFrames::read() tells of them.
VoxelType voxel_type_of(const DicomSlice& slice);

/// The pixels of slices of one sample a pixel, one slice after the other. What is not compressed is read as it is asked
/// for; else GDCM decodes a whole file at once, in a process of its own (ChildProcess): its codecs crash on damaged
/// data.
class DicomFrames {
 public:
  /// `slices`: those that read() will be called for, in that order.
  explicit DicomFrames(const std::vector<DicomSlice>& slices);
  ~DicomFrames();
  /// Writes the values of a slice, rescaled, as `type` to `to`; false where one lies beyond it, which is then its least
  /// or most: the same slice can be read again, as another type. Throws Error when the pixels cannot be decoded, are
  /// not what the header says, or the file ends early.
  bool read(const DicomSlice& slice, VoxelType type, void* to);

 private:
  void open(const DicomSlice& slice);
  void take_decoded(const DicomSlice& slice);
  const std::byte* stored(const DicomSlice& slice);

  std::unique_ptr<ChildProcess> decoder_;  ///< of the files that are compressed
  std::filesystem::path file_;             ///< that is open
  DicomPixels pixels_;
  VoxelType stored_type_ = VoxelType::UInt8;
  std::size_t frame_bytes_ = 0;
  std::ifstream stream_;           ///< for plain pixels
  std::vector<std::byte> buffer_;  ///< one frame of plain pixels, else all
};

/// Bytes of memory that DicomFrames takes for the file, its decoder among them.
std::size_t buffer_bytes(const DicomPixels& pixels);

}  // namespace simplexseg
