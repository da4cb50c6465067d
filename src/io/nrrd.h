// SPDX-License-Identifier: Apache-2.0
// Format: https://teem.sourceforge.net/nrrd/format.html.
#pragma once
#include <filesystem>
#include <string>

#include "io/volume_source.h"

namespace simplexseg {

class AtomicFile;

/// Opens NRRD, attached (.nrrd) or detached (.nhdr), in any of its encodings: raw, text, hexadecimal, gzip and bzip2.
/// The vectors of every anatomical space are turned to LPS and mm. Throws Error for a header that cannot be used,
/// voxels that the file cannot hold, or a unit that is no length.
VolumeSource open_nrrd(const std::filesystem::path& path, int volume = 1);

/// Writes NRRD with gzip'ed voxels, in LPS and mm; `keys` are lines of the header ("KEY:=text"). Throws Error when the
/// file cannot be written.
void write_nrrd(AtomicFile& file, const Volume& volume, const std::string& keys = "");

}  // namespace simplexseg
