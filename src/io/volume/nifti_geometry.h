// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/source/volume_info.h"
#include "io/volume/nifti_header.h"

namespace simplexseg {

/// Sets spacing, origin and direction from the sform, else from the qform. Adds a warning for each assumption.
void set_geometry(const NiftiHeader& header, VolumeInfo& info);

}  // namespace simplexseg
