// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/model/case_table.h"
#include "model/model_training.h"

namespace simplexseg {

/// Reads the image of a case and the object of each organ, which share the image; mirrors them left to right if the row
/// has `mirror`. Nothing for an organ that is not labelled. `image_number`: ModelCase::image_number. Throws the errors
/// of read_volume() and LabelFile, and Error for a label without voxels.
std::vector<std::optional<ModelCase>> load_model_cases(const TableCase& row, int image_number,
                                                       std::vector<std::string>& warnings);

/// Scale of intensities that suits images: Hounsfield if all contain air at -500 or below, as CT does.
IntensityScale scale_for(const std::vector<ModelCase>& cases);

}  // namespace simplexseg
