// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/source/volume_source.h"

namespace simplexseg {

/// Opens a MINC 1 or 2 file with libminc in a worker process and converts positions from RAS to LPS; `volume`: number
/// in a time series, from 1. The fastest axis of the file is the first. Throws Error if it is not a readable MINC
/// volume.
VolumeSource open_minc(const std::filesystem::path& path, int volume);

}  // namespace simplexseg
