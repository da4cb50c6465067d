// SPDX-License-Identifier: Apache-2.0
// Format: https://itk.org/Wiki/MetaIO/Documentation.
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

class AtomicFile;

/// Opens MetaImage, attached (.mha) or detached (.mhd), packed or not. Throws Error for a header that cannot be used or
/// voxels that the file cannot hold.
VolumeSource open_meta_image(const std::filesystem::path& path, int volume = 1);

/// Writes MetaImage with packed voxels in the same file. Throws Error when the file cannot be written.
void write_meta_image(AtomicFile& file, const Volume& volume);

}  // namespace simplexseg
