// SPDX-License-Identifier: Apache-2.0
#include "io/labels/labels_io.h"

#include "core/error.h"
#include "image/resample.h"
#include "io/platform/files.h"
#include "io/source/stored_header.h"

namespace simplexseg {

LoadedLabels load_labels(const std::filesystem::path& path, const LabelChoice& choice) {
  return LabelFile(path).read(choice);
}

void warn_of_other_frame(const std::string& frame_of_reference, const VolumeGeometry& grid,
                         const std::filesystem::path& path, std::vector<std::string>& warnings) {
  const DicomFrame* const image = stored_frame<DicomFrame>(grid);
  if (!image || frame_of_reference.empty() || frame_of_reference == image->frame_of_reference) return;
  warnings.push_back(quoted(path) + ": its frame of reference is not that of the image: positions may not correspond");
}

Volume resample_onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                          const std::string& grid_owner, std::vector<std::string>& warnings) {
  if (const DicomFrame* const frame = stored_frame<DicomFrame>(labels.geometry()))
    warn_of_other_frame(frame->frame_of_reference, grid, path, warnings);
  if (labels.geometry().same_grid(grid)) return labels;
  ResampledLabels resampled = resample_labels(labels, grid);
  if (resampled.outside == resampled.labelled) {
    throw Error("cannot use the labels " + quoted(path), "no labelled voxel lies within the grid of " + grid_owner,
                "use the labels of this image");
  }
  std::string warning = "the labels " + quoted(path) + " are on another grid than " + grid_owner +
                        ": each voxel gets the label at its centre";
  if (resampled.outside > 0)
    warning += "; " + std::to_string(resampled.outside) + " of " + std::to_string(resampled.labelled) +
               " labelled voxels lie outside it";
  warnings.push_back(warning);
  return std::move(resampled.labels);
}

Volume load_labels_onto(const std::filesystem::path& path, const VolumeGeometry& grid, const std::string& grid_owner,
                        std::vector<std::string>& warnings, const LabelChoice& choice) {
  return LabelFile(path).read_onto(grid, grid_owner, warnings, choice);
}

}  // namespace simplexseg
