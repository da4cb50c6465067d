// SPDX-License-Identifier: Apache-2.0
#include "cli/reference_mask.h"

#include <algorithm>
#include <cstdint>

#include "core/error.h"
#include "core/number_text.h"
#include "io/labels/label_file.h"
#include "io/platform/files.h"

namespace simplexseg {

Mask reference_mask(LabelFile& labels, const std::optional<double>& label, const VolumeGeometry& grid,
                    const std::string& path, const std::string& image) {
  const LoadedLabels& loaded = labels.labels({.label = label});
  if (!grid.same_grid(loaded.volume.geometry()))
    throw Error("cannot use " + quoted(path) + " as the reference for " + quoted(image),
                "their grids (size, spacing, origin or direction) differ", "resample one onto the grid of the other");
  Mask object = mask_of(loaded.volume, label);
  if (std::ranges::find(object.voxels, std::uint8_t{1}) == object.voxels.end())
    throw Error("cannot use " + quoted(path) + " as the reference",
                label ? "no voxel has the label " + exact_text(*label) : "all voxels are 0",
                "give a label that occurs");
  object.geometry = grid;  // the grids are equal up to rounding
  return object;
}

}  // namespace simplexseg
