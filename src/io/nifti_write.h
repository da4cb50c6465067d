// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

class AtomicFile;
class Volume;

/// Writes NIfTI-1 in one file, packed by gzip or not. Throws Error for more voxels along an axis than it can hold, or
/// when the file cannot be written.
void write_nifti(AtomicFile& file, const Volume& volume, bool packed);

}  // namespace simplexseg
