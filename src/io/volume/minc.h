// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens a MINC 1 or 2 file with libminc in a worker process. `volume`: number in a time series, from 1. Positions are
/// converted from RAS to LPS; the fastest axis of the file becomes the first axis of the volume. Throws Error if the
/// file is not a readable MINC volume, is too small for its voxels, or has no volume of that number.
VolumeSource open_minc(const std::filesystem::path& path, int volume);

}  // namespace simplexseg
