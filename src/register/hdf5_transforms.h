// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

#include "io/registration/registration_requests.h"

namespace simplexseg::in_register {

/// Transforms of an HDF5 file of ITK, in the order in which they act on a point. Throws itk::ExceptionObject for a
/// damaged file, and Error for kinds other than affine maps and displacement fields.
std::vector<TransformStep> read_hdf5_transforms(const std::filesystem::path& path);

}  // namespace simplexseg::in_register
