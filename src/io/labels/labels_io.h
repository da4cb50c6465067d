// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/labels/label_file.h"

namespace simplexseg {

/// Reads labels with LabelFile::read(): all labels of a file, or the chosen label alone where labels can share voxels.
LoadedLabels load_labels(const std::filesystem::path& path, const LabelChoice& choice = {});

/// Adds a warning if `frame_of_reference` of the labels in `path` is another than that of the image with this grid.
/// Adds nothing if one of them states none.
void warn_of_other_frame(const std::string& frame_of_reference, const VolumeGeometry& grid,
                         const std::filesystem::path& path, std::vector<std::string>& warnings);

/// Labels that were read from `path`, on `grid`. If they are on another grid, resamples them and adds a warning.
/// `grid_owner`: owner of the grid in messages, for example "the volume". Throws Error if no labelled voxel lies within
/// the grid.
Volume resample_onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                          const std::string& grid_owner, std::vector<std::string>& warnings);

/// Reads labels on a grid with LabelFile::read_onto(). Warnings begin with the file name.
Volume load_labels_onto(const std::filesystem::path& path, const VolumeGeometry& grid, const std::string& grid_owner,
                        std::vector<std::string>& warnings, const LabelChoice& choice = {});

}  // namespace simplexseg
