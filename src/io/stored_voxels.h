// SPDX-License-Identifier: Apache-2.0
// How files hold voxels, whatever their header: one reader for all formats that are a header and an array.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/packed_reader.h"
#include "io/volume_source.h"

namespace simplexseg {

/// How a file stores a voxel, and what it becomes in memory.
struct StoredType {
  int bytes;          ///< that each voxel takes in the file
  VoxelType type;     ///< that it is kept in
  bool wide = false;  ///< 64-bit integers, kept in 32 bits
};

/// The type that a header names by the C++ type of this size: 8-bit to 64-bit integers.
StoredType stored_integer(int bytes, bool has_sign);

enum class VoxelCode : std::uint8_t { Binary, Text, Hexadecimal };

/// Where the voxels of a volume are. All of its files hold as many of them.
struct StoredVoxels {
  std::vector<std::filesystem::path> files;  ///< in their order
  std::uint64_t offset = 0;                  ///< bytes in each file before what may be packed
  std::uint64_t skipped = 0;                 ///< bytes before the voxels, once unpacked
  bool at_end = false;  ///< the voxels end where the file ends; `offset` is the least that they have before them
  Packing packing = Packing::None;
  VoxelCode code = VoxelCode::Binary;
  StoredType type{1, VoxelType::UInt8};
  bool swapped = false;   ///< of the other byte order
  bool rescaled = false;  ///< a voxel is slope * stored + intercept, in the volume's floating type
  double slope = 1, intercept = 0;
  /// Of the volumes of a 4D file so many take turns voxel by voxel; else one follows the other. 0: they are mixed in
  /// another way, so that none can be read.
  int interleaved = 1;
};

/// The volume that a header describes, number `volume` of those in the files: `info` without the type, which follows
/// from the stored one, and without the warnings of type, axes and volume. Throws Error where its geometry cannot be
/// used or the files cannot hold what it claims, before any memory is taken for it; `header` is the file that is named
/// then. Reading throws Error when files end early, their packed data are damaged, or text in them is no number of the
/// type.
VolumeSource open_stored(VolumeInfo info, StoredVoxels voxels, const std::filesystem::path& header, int volume);

/// How many arrays of the first `dimension` axes make up one of these sizes.
double count_of_slices(std::span<const std::int64_t> sizes, std::int64_t dimension);

/// The files that a header lists, beside it. Throws Error when they are not as many as the slices.
std::vector<std::filesystem::path> listed_files(const std::filesystem::path& header,
                                                const std::vector<std::string>& names, double slices);

/// The files that a pattern as "slice%03d.raw" names for the numbers from `first` on in steps of `step`, `count` of
/// them, beside `header`. Throws Error when the pattern holds not exactly one such place.
std::vector<std::filesystem::path> numbered_files(const std::filesystem::path& header, const std::string& pattern,
                                                  long first, long step, int count);

}  // namespace simplexseg
