// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/source/volume_info.h"
#include "io/volume/nifti_header.h"

namespace simplexseg {

/// Sets spacing (mm), origin (LPS, mm) and direction from the sform, else from the qform. Without a valid one, uses the
/// voxel sizes with their signs, origin 0 and the axes of LPS. Keeps the fields for labels (NiftiFrame). Adds warnings
/// about assumptions, other units, and an sform and a qform that differ.
void set_geometry(const NiftiHeader& header, VolumeInfo& info);

}  // namespace simplexseg
