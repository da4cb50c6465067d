// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "io/model/case_table.h"
#include "model/model_training.h"

namespace simplexseg {

/// Reads image and object of a case; mirrors both left to right if the row has `mirror`. Throws the errors of
/// read_volume() and LabelFile, and Error for a label without voxels.
ModelCase load_model_case(const TableCase& row, std::vector<std::string>& warnings);

/// Scale of intensities that suits images: Hounsfield if all contain air at -500 or below, as CT does.
IntensityScale scale_for(const std::vector<ModelCase>& cases);

}  // namespace simplexseg
