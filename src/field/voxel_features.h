// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "field/box_image.h"
#include "field/mark_classifier.h"
#include "field/run_jobs.h"

namespace simplexseg {

/// What a voxel looks like: the image at three scales, how fast it changes at two, and how much it scatters. Each with
/// mean 0 and deviation 1 over the box; one that is the same everywhere is 0.
FeatureLists voxel_features(const std::vector<float>& image, const BoxGrid& grid,
                            const std::array<double, 3>& spacing_mm, const RunJobs& run);

}  // namespace simplexseg
