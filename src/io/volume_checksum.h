// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

class Volume;

/// Tells whether a volume is the one that a scene was made on: a CRC-32 over grid, voxel type and voxels, as
/// "crc32-1c291ca3-8388608", with the number of bytes. The same voxels have the same whatever file format they come
/// from. "" for an empty volume.
std::string checksum_of(const Volume& volume);

}  // namespace simplexseg
