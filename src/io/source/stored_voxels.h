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
  int bytes;          ///< size of a voxel in the file
  VoxelType type;     ///< type in memory
  bool wide = false;  ///< the file has 64-bit integers, which are converted to 32 bits
};

/// Returns the type for integers of 1, 2, 4 or 8 bytes.
StoredType stored_integer(int bytes, bool has_sign);

enum class VoxelEncoding : std::uint8_t { Binary, Text, Hexadecimal };

/// Location and encoding of the voxels of a volume. All its files contain the same number of voxels.
struct StoredVoxels {
  std::vector<std::filesystem::path> files;  ///< in reading order
  std::uint64_t offset = 0;                  ///< bytes in each file before the data (compressed or not)
  std::uint64_t skipped = 0;                 ///< bytes before the voxels, after decompression
  bool at_end = false;                       ///< the voxels are the last bytes of the file; `offset` is then a minimum
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
/// warnings on type, axes and volume, which are added here. Throws Error naming `header` when the geometry is invalid
/// or the files are too small for it; this is checked before memory is allocated. Reading the voxels throws Error when
/// a file is truncated, its compressed data is damaged, or a text voxel is not a number of the type.
VolumeSource open_stored(VolumeInfo info, StoredVoxels voxels, const std::filesystem::path& header, int volume);

/// Number of arrays of the first `dimension` axes in an array of these sizes.
double count_of_slices(std::span<const std::int64_t> sizes, std::int64_t dimension);

/// Paths of the files listed in a header, relative to it. Throws Error when their number differs from `slices`.
std::vector<std::filesystem::path> listed_files(const std::filesystem::path& header,
                                                const std::vector<std::string>& names, double slices);

/// Paths of `count` files named by a pattern such as "slice%03d.raw", relative to `header`. Their numbers start at
/// `first` and increase by `step`. Throws Error unless the pattern contains exactly one number placeholder.
std::vector<std::filesystem::path> numbered_files(const std::filesystem::path& header, const std::string& pattern,
                                                  long first, long step, int count);

}  // namespace simplexseg
