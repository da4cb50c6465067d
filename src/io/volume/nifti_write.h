// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

class AtomicFile;
class Volume;

/// Writes a single-file NIfTI-1 volume; `compress` compresses it with gzip. Throws Error for more than 32767 voxels
/// along an axis or a failed write.
void write_nifti(AtomicFile& file, const Volume& volume, bool compress);

}  // namespace simplexseg
