// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "model/organ_model.h"

namespace simplexseg {

/// Distribution of shapes and poses of cases: principal components of the shapes after similarity alignment, and a
/// Gaussian process whose variance decreases with the number of cases. `neighbours`: of the vertices; `most_modes`:
/// largest number of modes. At least one case.
ShapeModel train_shape(const std::vector<std::array<int, 3>>& neighbours, const std::vector<const TrainedCase*>& cases,
                       int most_modes);

/// Distribution of the profiles of cases. `sampling`: scale, step, cell and surroundings of the profiles; `profiles`:
/// of each case, as TrainedCase::profiles. At least one case.
ProfileModel train_profiles(const ProfileModel& sampling, const std::vector<std::array<int, 3>>& neighbours,
                            const std::vector<const std::vector<float>*>& profiles);

}  // namespace simplexseg
