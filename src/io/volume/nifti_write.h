// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

class AtomicFile;
class Volume;

/// Writes a single-file NIfTI volume; `compress` compresses it with gzip. A grid read from NIfTI or Analyze is written
/// with the qform, sform, codes and unit of its file, in its version of NIfTI; other grids as NIfTI-1 with an sform
/// and, unless sheared, an equal qform. Throws Error for more than 32767 voxels along an axis in NIfTI-1 or a failed
/// write.
void write_nifti(AtomicFile& file, const Volume& volume, bool compress);

}  // namespace simplexseg
