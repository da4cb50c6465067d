// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "field/box_image.h"
#include "field/mark_classifier.h"
#include "field/run_jobs.h"

namespace simplexseg {

/// Number of voxel_features() of an image.
inline constexpr int kVoxelFeatures = 6;

/// Intensity features of the voxels of a box: Gaussians of three scales, gradient lengths of two, local standard
/// deviation. Each has mean 0 and standard deviation 1 over the box; constant features are 0.
FeatureLists voxel_features(const std::vector<float>& image, const BoxGrid& grid,
                            const std::array<double, 3>& spacing_mm, const RunJobs& run);

}  // namespace simplexseg
