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
/// Reads a label volume, or an RT structure set whose contours become labels on their own grid (grid_of_regions()). For
/// a structure set, rasterises only the chosen region and ignores the part in `choice`. Throws the errors of
/// load_volume(), grid_of_regions() and label_of().
LoadedLabels load_labels(const std::filesystem::path& path, const LabelChoice& choice = {});
/// Labels of regions that were read from `path`, as in load_labels().
LoadedLabels labels_of_regions(const std::vector<StructureRegion>& regions, const LabelChoice& choice,
                               const std::filesystem::path& path);
/// Number of the chosen label; nullopt if all labels are chosen. Prefers an exact match of the name, then a match that
/// ignores case. Throws Error if `names` has no such label.
std::optional<double> label_of(const LabelChoice& choice, const std::vector<SegmentName>& names,
                               const std::filesystem::path& path);
/// Regions of an RT structure set that have a volume, each counted on its own grid (load_labels()). Throws Error if the
/// file cannot be read or has no such region.
std::vector<LabelCount> list_regions(const std::filesystem::path& path);

/// Resamples labels that were read from `path` onto a grid if theirs differs, and adds a warning. `grid_owner`: name of
/// the grid in messages, for example "the volume". Throws Error if no labelled voxel lies within the grid.
Volume resample_onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                          const std::string& grid_owner, std::vector<std::string>& warnings);

/// Reads labels onto a grid: a label volume, resampled by resample_onto_grid(), or the contours of an RT structure set.
/// Warnings begin with the file name. Throws the errors of load_volume(), resample_onto_grid() and
/// read_structure_set().
Volume load_labels_onto(const std::filesystem::path& path, const VolumeGeometry& grid, const std::string& grid_owner,
                        std::vector<std::string>& warnings);

}  // namespace simplexseg
