// SPDX-License-Identifier: Apache-2.0
// Format: https://itk.org/Wiki/MetaIO/Documentation.
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

class AtomicFile;

/// Opens a MetaImage file, attached (.mha) or detached (.mhd), compressed or not. `volume`: number in a 4D file, from
/// 1. Throws Error for an invalid header, a file that is too small, or an invalid volume number.
VolumeSource open_meta_image(const std::filesystem::path& path, int volume = 1);

/// Writes an attached MetaImage file with compressed voxels. A grid read from MetaImage is placed by the lines of its
/// file (MetaImageFrame). Throws Error when the file cannot be written.
void write_meta_image(AtomicFile& file, const Volume& volume);

}  // namespace simplexseg
