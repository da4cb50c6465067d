// SPDX-License-Identifier: Apache-2.0
#include "io/labels_io.h"

#include "core/error.h"
#include "image/resample.h"
#include "io/files.h"
#include "io/rtstruct_read.h"
#include "io/volume_io.h"

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

Volume load_labels_onto(const std::filesystem::path& path, const VolumeGeometry& grid, const std::string& what,
                        std::vector<std::string>& warnings) {
  const auto add = [&](const std::vector<std::string>& said) {
    for (const std::string& warning : said) warnings.push_back(quoted(path) + ": " + warning);
  };
  if (is_structure_set(path)) {
    StructureLabels read = read_structure_set(path, grid);
    add(read.warnings);
    return std::move(read.labels);
  }
  const LoadedVolume loaded = load_volume(path);
  add(loaded.warnings);
  return onto_grid(loaded.volume, grid, path, what, warnings);
}

}  // namespace simplexseg
