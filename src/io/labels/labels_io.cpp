// SPDX-License-Identifier: Apache-2.0
#include "io/labels/labels_io.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "core/error.h"
#include "image/resample.h"
#include "io/dicom/rtstruct_grid.h"
#include "io/dicom/rtstruct_read.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

/// Number of slices without a label between the first and the last labelled slice.
int empty_slices(const Volume& labels) {
  const std::span<const std::uint16_t> voxels = labels.voxels<std::uint16_t>();
  const auto slices = static_cast<std::size_t>(labels.geometry().size[2]), count = voxels.size() / slices;
  int empty = 0, since = -1;  // empty slices since the last labelled slice; -1 before the first
  for (std::size_t k = 0; k < slices; ++k) {
    const auto slice = voxels.subspan(k * count, count);
    const bool any = std::any_of(slice.begin(), slice.end(), [](std::uint16_t v) { return v != 0; });
    if (any && since > 0) empty += since;
    if (any || since >= 0) since = any ? 0 : since + 1;
  }
  return empty;
}

/// Adds the file name to the start of each warning.
LoadedLabels with_file_name(LoadedLabels labels, const std::filesystem::path& path) {
  for (std::string& warning : labels.warnings) warning.insert(0, quoted(path) + ": ");
  return labels;
}

}  // namespace

std::optional<double> label_of(const LabelChoice& choice, const std::vector<SegmentName>& names,
                               const std::filesystem::path& path) {
  if (choice.name.empty()) return choice.label;
  std::string present;
  const SegmentName* found = nullptr;
  for (const SegmentName& name : names) {
    if (name.name == choice.name) return name.value;
    if (lower_case(name.name) == lower_case(choice.name)) found = &name;
    present.append(present.empty() ? "" : ", ").append(one_line(name.name, 60));
  }
  if (found) return found->value;
  throw Error(quoted(path) + " has no label named '" + one_line(choice.name, 60) + "'",
              present.empty() ? "its labels have no names" : "its labels are " + present,
              present.empty() ? "use the number of the label" : "use one of these names");
}

LoadedLabels labels_of_regions(const std::vector<StructureRegion>& regions, const LabelChoice& choice,
                               const std::filesystem::path& path) {
  LoadedLabels loaded;
  for (const StructureRegion& region : regions) loaded.segments.push_back(region.name);
  const std::optional<double> label = label_of(choice, loaded.segments, path);
  std::vector<StructureRegion> chosen = regions;
  if (label) std::erase_if(chosen, [&](const StructureRegion& r) { return r.name.value != *label; });
  StructureLabels rasterised = rasterise_regions(chosen, grid_of_regions(chosen, regions, path), path);
  loaded.volume = std::move(rasterised.labels);
  loaded.warnings = std::move(rasterised.warnings);
  if (const int empty = empty_slices(loaded.volume); empty > 0)
    loaded.warnings.push_back(std::to_string(empty) + (empty == 1 ? " slice" : " slices") +
                              " between the first and the last " + (empty == 1 ? "has" : "have") +
                              " no contour and stay" + (empty == 1 ? "s" : "") + " unlabelled");
  return with_file_name(std::move(loaded), path);
}

LoadedLabels load_labels(const std::filesystem::path& path, const LabelChoice& choice) {
  if (is_structure_set(path)) return labels_of_regions(read_structure_regions(path), choice, path);
  LoadedVolume read = load_volume(path);
  return with_file_name({std::move(read.volume), std::move(read.segments), std::move(read.warnings)}, path);
}

std::vector<LabelCount> list_regions(const std::filesystem::path& path) {
  const std::vector<StructureRegion> regions = read_structure_regions(path);
  std::vector<LabelCount> result;
  for (const StructureRegion& region : regions) {  // separately, since regions may overlap
    try {
      const LoadedLabels loaded = labels_of_regions(regions, {.label = region.name.value}, path);
      for (LabelCount& count : count_labels(loaded.volume, {region.name})) result.push_back(std::move(count));
    } catch (const Error&) {
      continue;  // points and lines have no volume
    }
  }
  if (result.empty()) labels_of_regions(regions, {}, path);  // throws the Error with the reason
  return result;
}

Volume resample_onto_grid(const Volume& labels, const VolumeGeometry& grid, const std::filesystem::path& path,
                          const std::string& grid_owner, std::vector<std::string>& warnings) {
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
                        std::vector<std::string>& warnings) {
  if (is_structure_set(path)) {
    StructureLabels read = read_structure_set(path, grid);
    for (const std::string& warning : read.warnings) warnings.push_back(quoted(path) + ": " + warning);
    return std::move(read.labels);
  }
  LoadedLabels loaded = load_labels(path);
  std::move(loaded.warnings.begin(), loaded.warnings.end(), std::back_inserter(warnings));
  return resample_onto_grid(loaded.volume, grid, path, grid_owner, warnings);
}

}  // namespace simplexseg
