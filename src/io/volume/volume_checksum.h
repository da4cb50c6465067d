// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

class Volume;

/// Identifies the volume of a scene: CRC-32 over grid, voxel type and voxels, then the number of bytes, for example
/// "crc32-1c291ca3-8388608". Independent of the file format; "" for an empty volume.
std::string checksum_of(const Volume& volume);

}  // namespace simplexseg
