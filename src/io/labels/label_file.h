// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom/rtstruct_read.h"
#include "io/labels/label_mesh.h"
#include "io/source/segment_names.h"

namespace simplexseg {

struct VolumeSource;  // io/source/volume_source.h

/// Labels read from a file.
struct LoadedLabels {
  Volume volume;
  std::vector<SegmentName> segments;  ///< label names in the file; empty if it has none
  std::vector<std::string> warnings;  ///< one line each, beginning with the file name
};

/// Number of the chosen label; nullopt if all labels are chosen. A name matches exactly or, if there is no exact match,
/// in upper or lower case. `path`: file in messages. Throws Error if `names` does not contain the chosen name.
std::optional<double> label_of(const LabelChoice& choice, const std::vector<SegmentName>& names,
                               const std::filesystem::path& path);

/// Labels of regions that were read from the structure set `path`, on their own grid (grid_of_regions()). If `choice`
/// has a label, only that region is rasterised. Throws Error if `choice` is not a region, and the errors of
/// grid_of_regions() and rasterise_regions().
LoadedLabels labels_of_regions(const std::vector<StructureRegion>& regions, const LabelChoice& choice,
                               const std::filesystem::path& path);

/// Open label volume or RT structure set. Where labels can share voxels (RT structure set, DICOM segmentation, layers
/// of a .seg.nrrd file), a chosen label is read alone, so that no other label hides a part of it. If all are read
/// together, a voxel of several labels has one of them, with a warning about the number of such voxels.
class LabelFile {
 public:
  /// Reads the header of a label volume or the contours of a structure set. Throws the errors of open_volume() and
  /// read_structure_regions().
  explicit LabelFile(std::filesystem::path path);
  ~LabelFile();
  LabelFile(LabelFile&&) noexcept;
  LabelFile& operator=(LabelFile&&) noexcept;

  /// Names and colours of the labels in the file; empty if it has none.
  const std::vector<SegmentName>& segments() const;
  /// Whether a chosen label is read alone; otherwise every choice reads the whole volume.
  bool reads_alone() const;

  /// Reads the chosen label, or all if the choice has none; LabelChoice::part is ignored. A volume whose labels cannot
  /// share voxels contains all of its labels for any choice, and is converted by make_whole_labels(). Throws Error for
  /// a name or, if labels are read alone, a number that the file does not have, and the errors of load_volume(),
  /// make_whole_labels() and labels_of_regions().
  LoadedLabels read(const LabelChoice& choice = {}) const;
  /// Result of read(), which is kept for the next call with an equal choice; valid until the next call.
  const LoadedLabels& labels(const LabelChoice& choice = {});
  /// Result of read() on `grid`: regions of a structure set are rasterised there, a label volume is resampled by
  /// resample_onto_grid(), whose arguments are `grid_owner` and `warnings`. Adds the warnings of read() to `warnings`.
  Volume read_onto(const VolumeGeometry& grid, const std::string& grid_owner, std::vector<std::string>& warnings,
                   const LabelChoice& choice = {}) const;
  /// Labels with their sizes, see count_labels(). Labels that are read alone are counted alone. Points and lines of a
  /// structure set are omitted. Throws the errors of read() and count_labels(), and Error if no region of a structure
  /// set has a volume.
  std::vector<LabelCount> count();

 private:
  std::optional<double> number_of(const LabelChoice& choice) const;

  std::filesystem::path path_;
  std::unique_ptr<const VolumeSource> source_;  ///< null for a structure set
  std::vector<StructureRegion> regions_;        ///< of a structure set
  std::vector<SegmentName> segments_;
  std::optional<LabelChoice> kept_choice_;  ///< choice of `kept_`, without name and part
  LoadedLabels kept_;
};

}  // namespace simplexseg
