// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

/// Brings labels that were read from `path` onto a grid where theirs differs, and says so in `warnings`. `what` names
/// the grid's owner: "the volume". Throws Error when the grids differ and no labelled voxel lies within the grid.
Volume onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                 const std::string& what, std::vector<std::string>& warnings);

}  // namespace simplexseg
