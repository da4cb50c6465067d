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

/// Reads labels onto a grid: a label volume, resampled as onto_grid() does, or the contours of an RT structure set.
/// Everything that is to be known of it is added to `warnings`, the file's name in front. Throws Error as
/// load_volume(), onto_grid() and read_structure_set() do.
Volume load_labels_onto(const std::filesystem::path& path, const VolumeGeometry& grid, const std::string& what,
                        std::vector<std::string>& warnings);

}  // namespace simplexseg
