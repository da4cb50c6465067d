// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

enum class ItkFormat { MetaImage, Nrrd, Minc };
VolumeSource open_itk(const std::filesystem::path& path, ItkFormat format);

/// Writes NRRD or, where the name does not end in .nrrd, MetaImage: the whole file at `path` (the target's temporary).
/// Throws Error or std::exception.
void write_itk(const std::filesystem::path& path, const Volume& volume);

}  // namespace simplexseg
