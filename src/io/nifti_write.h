// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace simplexseg {

class Volume;

/// Writes NIfTI-1 in one file, packed where the name ends in .gz: the whole file at `path` (the target's temporary).
/// Throws Error or std::exception.
void write_nifti(const std::filesystem::path& path, const Volume& volume);

}  // namespace simplexseg
