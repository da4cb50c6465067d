// SPDX-License-Identifier: Apache-2.0
#include "io/labels_io.h"

#include "core/error.h"
#include "image/resample.h"
#include "io/files.h"

namespace simplexseg {

Volume onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                 const std::string& what, std::vector<std::string>& warnings) {
  if (labels.geometry().same_grid(grid)) return labels;
  ResampledLabels resampled = resample_labels(labels, grid);
  if (resampled.outside == resampled.labelled) {
    throw Error("cannot use the labels " + quoted(path),
                "their grid differs from that of " + what + ", and no labelled voxel lies within it",
                "give the labels of this image");
  }
  std::string warning =
      "the labels " + quoted(path) + " are on another grid than " + what + ": each voxel takes the label at its centre";
  if (resampled.outside > 0)
    warning += "; " + std::to_string(resampled.outside) + " of " + std::to_string(resampled.labelled) +
               " labelled voxels lie outside of it";
  warnings.push_back(warning);
  return std::move(resampled.labels);
}

}  // namespace simplexseg
