// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace simplexseg {

class Volume;

/// Checksum that identifies the volume of a scene: CRC-32 of grid, voxel type and voxels, and the size of the voxels in
/// bytes, for example "crc32-1c291ca3-8388608"; "" for an empty volume. It does not include the name or format of the
/// file.
std::string checksum_of(const Volume& volume);

}  // namespace simplexseg
