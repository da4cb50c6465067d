// SPDX-License-Identifier: Apache-2.0
// Reader of voxel arrays, shared by all formats that consist of a header and an array.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/platform/decompressing_reader.h"
#include "io/source/volume_source.h"

namespace simplexseg {

/// Type of a voxel in the file and in memory.
struct StoredType {
  int bytes;          ///< size of a voxel in the file, bytes
  VoxelType type;     ///< type in memory
  bool wide = false;  ///< the file contains 64-bit integers, which are converted to 32 bits
};

/// Returns the type for integers of 1, 2, 4 or 8 bytes.
StoredType stored_integer(int bytes, bool has_sign);

enum class VoxelEncoding : std::uint8_t { Binary, Text, Hexadecimal };

/// Location and encoding of the voxels of a volume. All files contain the same number of voxels.
struct StoredVoxels {
  std::vector<std::filesystem::path> files;  ///< in reading order
  std::uint64_t offset = 0;                  ///< bytes in each file before the (possibly compressed) data
  std::uint64_t skipped = 0;                 ///< bytes of decompressed data before the voxels
  bool at_end = false;                       ///< the voxels are the last bytes of each file; `offset` is a minimum
  Compression compression = Compression::None;
  VoxelEncoding encoding = VoxelEncoding::Binary;
  StoredType type{1, VoxelType::UInt8};
  bool swapped = false;   ///< byte order differs from the machine's
  bool rescaled = false;  ///< voxel = slope * stored + intercept, as floating-point number
  double slope = 1, intercept = 0;
  /// Number of volumes of a 4D file that are interleaved voxel by voxel; 1: volumes are stored one after the other;
  /// 0: another interleaving, which cannot be read.
  int interleaved = 1;
};

/// Opens volume number `volume` (from 1) of the files. `info` is the header without the voxel type and without the
/// warnings on type, axes and volume, which are added here. Throws Error when the geometry is invalid, the volume does
/// not exist, or a file is missing or too small; this is checked before memory is allocated. `header` is the name of
/// the header file in messages. VolumeSource::read() throws Error when a file is truncated, its compressed data is
/// damaged, or a text voxel is not a number of the type.
VolumeSource open_stored(VolumeInfo info, StoredVoxels voxels, const std::filesystem::path& header, int volume);

/// Returns the number of subarrays of the first `dimension` axes in an array of these sizes: the product of all further
/// sizes.
double count_of_slices(std::span<const std::int64_t> sizes, std::int64_t dimension);

/// Returns the paths of the files listed in a header. Relative names refer to the folder of the header. Throws Error
/// when their number differs from `slices`.
std::vector<std::filesystem::path> listed_files(const std::filesystem::path& header,
                                                const std::vector<std::string>& names, double slices);

/// Returns the paths of `count` files named by a pattern such as "slice%03d.raw" in the folder of `header`. The numbers
/// in the names start at `first` and increase by `step`. Throws Error unless the pattern contains exactly one number
/// placeholder.
std::vector<std::filesystem::path> numbered_files(const std::filesystem::path& header, const std::string& pattern,
                                                  long first, long step, int count);

}  // namespace simplexseg
