// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/volume_source.h"

namespace simplexseg {

/// Opens MINC 1 and 2, by libminc in a process of its own, its world turned from RAS to LPS; of several volumes in
/// time, number `volume`. The file's fastest axis is the first. Throws Error when it is none, or cannot be read.
VolumeSource open_minc(const std::filesystem::path& path, int volume);

}  // namespace simplexseg
