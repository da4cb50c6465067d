// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/label_mesh.h"
#include "io/rtstruct_read.h"
#include "io/segment_names.h"

namespace simplexseg {

/// Labels as their file has them.
struct LoadedLabels {
  Volume volume;
  std::vector<SegmentName> segments;  ///< names that the file gives, empty where it gives none
  std::vector<std::string> warnings;  ///< one line each, the file's name in front
};
/// Reads labels, of which those of `choice` are wanted, whatever its part: a label volume, or an RT structure set,
/// whose contours become labels on a grid of their own (grid_of_regions()), those of the region alone that is asked
/// for. Throws Error as load_volume(), grid_of_regions() and label_of() do.
LoadedLabels load_labels(const std::filesystem::path& path, const LabelChoice& choice = {});
/// The same of regions that were read from `path`.
LoadedLabels labels_of_regions(const std::vector<StructureRegion>& regions, const LabelChoice& choice,
                               const std::filesystem::path& path);
/// The number of the label that is chosen; nothing where every label is. A name in another case is taken where no other
/// is the same. Throws Error when `names` do not have it.
std::optional<double> label_of(const LabelChoice& choice, const std::vector<SegmentName>& names,
                               const std::filesystem::path& path);
/// The regions of an RT structure set that are volumes, each on the grid that load_labels() would give it. Throws Error
/// when the file cannot be read, or there is none.
std::vector<LabelCount> list_regions(const std::filesystem::path& path);

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
