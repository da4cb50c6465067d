// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <vector>

namespace simplexseg {

class AtomicFile;
class Volume;
struct VolumeGeometry;

/// Writes a single-file NIfTI volume; `compress` compresses it with gzip. A grid read from NIfTI or Analyze is written
/// with the qform, sform, codes and unit of its file, in its version of NIfTI; other grids as NIfTI-1 with an sform
/// and, unless sheared, an equal qform. Throws Error for more than 32767 voxels along an axis in NIfTI-1 or a failed
/// write.
void write_nifti(AtomicFile& file, const Volume& volume, bool compress);

/// Writes one vector for each voxel of a grid, i fastest: NIfTI-1 with three components along the fifth dimension and
/// the intent "vector" (1007). Throws Error like write_nifti().
void write_nifti_vectors(AtomicFile& file, const VolumeGeometry& grid, const std::vector<Eigen::Vector3f>& vectors,
                         bool compress);

}  // namespace simplexseg
