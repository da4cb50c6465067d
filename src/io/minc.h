// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// Opens MINC 2, its world turned from RAS to LPS. Throws Error when it is none, or cannot be read.
VolumeSource open_minc(const std::filesystem::path& path);

}  // namespace simplexseg
