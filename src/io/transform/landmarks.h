// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "image/transform.h"

namespace simplexseg {

/// Corresponding points of two images, mm in LPS.
struct Landmarks {
  std::vector<Eigen::Vector3d> fixed, moving;
};

/// Reads a table of landmarks (.csv): in each row x, y, z in the fixed image and x, y, z in the moving image, separated
/// by commas, semicolons or white space. A first row with names and empty rows are skipped. Throws Error for a row
/// without six finite numbers, no row, or more than 100000 rows.
Landmarks read_landmarks(const std::filesystem::path& path);

/// Distances of the mapped landmarks from their counterparts, mm.
std::vector<double> residuals_mm(const Transform& transform, const Landmarks& landmarks);

}  // namespace simplexseg
