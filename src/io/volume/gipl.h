// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Whether a file, compressed or not, has the magic number of GIPL. Throws Error when it cannot be opened.
bool is_gipl_file(const std::filesystem::path& path);

/// Opens a GIPL file (Guy's Image Processing Lab), compressed with gzip or not. `volume`: number in a 4D file, from 1.
/// Voxel sizes and origin are in mm; the format has no common orientation, so a warning is added. Throws Error for an
/// invalid header, a file that is too small, or an invalid volume number.
VolumeSource open_gipl(const std::filesystem::path& path, int volume = 1);

}  // namespace simplexseg
