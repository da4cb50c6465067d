// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom/rtstruct_read.h"
#include "io/labels/label_mesh.h"
#include "io/source/segment_names.h"

namespace simplexseg {

/// Labels read from a file.
struct LoadedLabels {
  Volume volume;
  std::vector<SegmentName> segments;  ///< label names in the file; empty if it has none
  std::vector<std::string> warnings;  ///< one line each, beginning with the file name
};
/// Reads a label volume, for which `choice` is ignored, or an RT structure set, whose contours become labels on their
/// own grid (grid_of_regions()). If `choice` has a label, only that region of a structure set is rasterised. Throws the
/// errors of load_volume(), read_structure_regions(), grid_of_regions() and label_of().
LoadedLabels load_labels(const std::filesystem::path& path, const LabelChoice& choice = {});
/// Labels of regions that were read from the structure set `path`, as in load_labels().
LoadedLabels labels_of_regions(const std::vector<StructureRegion>& regions, const LabelChoice& choice,
                               const std::filesystem::path& path);
/// Number of the chosen label; nullopt if all labels are chosen. A name matches exactly or, if there is no exact match,
/// in upper or lower case. `path`: file in messages. Throws Error if `names` does not contain the chosen name.
std::optional<double> label_of(const LabelChoice& choice, const std::vector<SegmentName>& names,
                               const std::filesystem::path& path);
/// Regions of an RT structure set that have a volume, each rasterised separately to count its voxels (load_labels()).
/// Throws Error if the file cannot be read or has no such region.
std::vector<LabelCount> list_regions(const std::filesystem::path& path);

/// Labels that were read from `path`, on `grid`. If they are on another grid, resamples them and adds a warning.
/// `grid_owner`: owner of the grid in messages, for example "the volume". Throws Error if no labelled voxel lies within
/// the grid.
Volume resample_onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                          const std::string& grid_owner, std::vector<std::string>& warnings);

/// Reads labels on a grid: a label volume, resampled by resample_onto_grid(), or rasterised contours of a structure
/// set. Warnings begin with the file name. Throws the errors of load_volume(), resample_onto_grid() and
/// read_structure_set().
Volume load_labels_onto(const std::filesystem::path& path, const VolumeGeometry& grid, const std::string& grid_owner,
                        std::vector<std::string>& warnings);

}  // namespace simplexseg
