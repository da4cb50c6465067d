// SPDX-License-Identifier: Apache-2.0
// Format: https://teem.sourceforge.net/nrrd/format.html.
#pragma once
#include <filesystem>
#include <string>

#include "io/source/volume_source.h"

namespace simplexseg {

class AtomicFile;

/// Opens a NRRD file, attached (.nrrd) or detached (.nhdr), encoded as raw, text, hexadecimal, gzip or bzip2. `volume`:
/// number in a 4D file, from 1. Positions and directions in an anatomical space are converted to LPS and mm. Throws
/// Error for an invalid header, a file that is too small, a unit that is not a length, or an invalid volume number.
VolumeSource open_nrrd(const std::filesystem::path& path, int volume = 1);

/// Writes an attached NRRD file with gzip encoding, in LPS and mm. A grid read from NRRD is placed by the fields of its
/// file (NrrdFrame). `keys`: further header lines "KEY:=text", each with
/// a line break at its end. Throws Error when the file cannot be written.
void write_nrrd(AtomicFile& file, const Volume& volume, const std::string& keys = "");

}  // namespace simplexseg
