// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/nifti_header.h"
#include "io/volume_io.h"

namespace simplexseg {

/// Takes spacing, origin and direction, from the sform before the qform; what had to be assumed becomes a warning.
void set_geometry(const NiftiHeader& header, VolumeInfo& info);

}  // namespace simplexseg
