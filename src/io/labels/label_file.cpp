// SPDX-License-Identifier: Apache-2.0
#include "io/labels/label_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "io/dicom/rtstruct_grid.h"
#include "io/dicom/rtstruct_raster.h"
#include "io/labels/labels_io.h"
#include "io/platform/files.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// Adds the file name to the start of each warning.
LoadedLabels with_file_name(LoadedLabels labels, const fs::path& path) {
  for (std::string& warning : labels.warnings) warning.insert(0, quoted(path) + ": ");
  return labels;
}

std::vector<SegmentName> names_of(const std::vector<StructureRegion>& regions) {
  std::vector<SegmentName> names;
  names.reserve(regions.size());
  for (const StructureRegion& region : regions) names.push_back(region.name);
  return names;
}

/// Throws Error if there is no label with this number.
void require_number(double number, const std::vector<SegmentName>& names, const fs::path& path) {
  std::string present;
  for (const SegmentName& name : names) {
    if (name.value == number) return;
    present += (present.empty() ? "" : ", ") + std::to_string(name.value);
    if (!name.name.empty()) present += " (" + one_line(name.name, 60) + ")";
  }
  throw Error(quoted(path) + " has no label " + exact_text(number),
              present.empty() ? "it has no labels" : "its labels are " + present,
              present.empty() ? "use another file" : "choose one of them");
}

/// Number of a segment; 0, which no segment has, for a label that cannot be one.
int segment_of(double label) {
  constexpr double kMaxSegment = 65535;
  return label >= 1 && label <= kMaxSegment && label == std::floor(label) ? static_cast<int>(label) : 0;
}

/// Whether all voxels are 0.
bool is_blank(const Volume& labels) {
  return visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = labels.voxels<T>();
    return std::all_of(voxels.begin(), voxels.end(), [](T v) { return v == T(0); });
  });
}

std::vector<StructureRegion> regions_with(const std::vector<StructureRegion>& regions, std::optional<double> number,
                                          const fs::path& path) {
  if (!number) return regions;
  require_number(*number, names_of(regions), path);
  std::vector<StructureRegion> chosen;
  for (const StructureRegion& region : regions)
    if (region.name.value == *number) chosen.push_back(region);
  return chosen;
}

}  // namespace

std::optional<double> label_of(const LabelChoice& choice, const std::vector<SegmentName>& names, const fs::path& path) {
  if (choice.name.empty()) return choice.label;
  std::string present;
  const SegmentName* found = nullptr;
  for (const SegmentName& name : names) {
    if (name.name == choice.name) return name.value;
    if (lower_ascii(name.name) == lower_ascii(choice.name)) found = &name;
    present.append(present.empty() ? "" : ", ").append(one_line(name.name, 60));
  }
  if (found) return found->value;
  throw Error(quoted(path) + " has no label named '" + one_line(choice.name, 60) + "'",
              present.empty() ? "its labels have no names" : "its labels are " + present,
              present.empty() ? "use the number of the label" : "use one of these names");
}

LoadedLabels labels_of_regions(const std::vector<StructureRegion>& regions, const LabelChoice& choice,
                               const fs::path& path) {
  LoadedLabels loaded;
  loaded.segments = names_of(regions);
  const std::vector<StructureRegion> chosen = regions_with(regions, label_of(choice, loaded.segments, path), path);
  StructureLabels rasterised = rasterise_regions(chosen, grid_of_regions(chosen, regions, path), path, regions);
  loaded.volume = std::move(rasterised.labels);
  loaded.warnings = std::move(rasterised.warnings);
  return with_file_name(std::move(loaded), path);
}

LabelFile::LabelFile(fs::path path) : path_(std::move(path)) {
  if (is_structure_set(path_)) {
    regions_ = read_structure_regions(path_);
    segments_ = names_of(regions_);
  } else {
    source_ = std::make_unique<const VolumeSource>(open_volume(path_));
    segments_ = source_->info.segments;
  }
}

LabelFile::~LabelFile() = default;
LabelFile::LabelFile(LabelFile&&) noexcept = default;
LabelFile& LabelFile::operator=(LabelFile&&) noexcept = default;

const std::vector<SegmentName>& LabelFile::segments() const { return segments_; }

bool LabelFile::reads_alone() const { return !source_ || source_->read_segment; }

std::optional<double> LabelFile::number_of(const LabelChoice& choice) const {
  return label_of(choice, segments_, path_);
}

LoadedLabels LabelFile::read(const LabelChoice& choice) const {
  if (!source_) return labels_of_regions(regions_, choice, path_);
  LabelChoice chosen = choice;
  chosen.label = number_of(choice);
  const bool alone = source_->read_segment && chosen.label;
  LoadedVolume read = load_volume(*source_, path_, alone ? std::optional(segment_of(*chosen.label)) : std::nullopt);
  if (alone && is_blank(read.volume)) require_number(*chosen.label, segments_, path_);
  make_whole_labels(read.volume, chosen, quoted(path_), read.warnings);
  return with_file_name({std::move(read.volume), segments_, std::move(read.warnings)}, path_);
}

const LoadedLabels& LabelFile::labels(const LabelChoice& choice) {
  LabelChoice chosen;
  chosen.threshold = choice.threshold;
  const std::optional<double> number = number_of(choice);
  if (reads_alone() || choice.threshold) chosen.label = number;
  if (!kept_choice_ || kept_choice_->label != chosen.label || kept_choice_->threshold != chosen.threshold) {
    kept_choice_.reset();
    kept_ = {};  // releases the memory before the next volume is read
    kept_ = read(chosen);
    kept_choice_ = chosen;
  }
  return kept_;
}

Volume LabelFile::read_onto(const VolumeGeometry& grid, const std::string& grid_owner,
                            std::vector<std::string>& warnings, const LabelChoice& choice) const {
  if (!source_) {
    const std::vector<StructureRegion> chosen = regions_with(regions_, number_of(choice), path_);
    if (!chosen.empty()) warn_of_other_frame(chosen.front().frame_of_reference, grid, path_, warnings);
    StructureLabels read = rasterise_regions(chosen, grid, path_, regions_);
    for (const std::string& warning : read.warnings) warnings.push_back(quoted(path_) + ": " + warning);
    return std::move(read.labels);
  }
  LoadedLabels loaded = read(choice);
  std::move(loaded.warnings.begin(), loaded.warnings.end(), std::back_inserter(warnings));
  return resample_onto_grid(loaded.volume, grid, path_, grid_owner, warnings);
}

std::vector<LabelCount> LabelFile::count() {
  if (!reads_alone()) return count_labels(labels().volume, segments_);
  std::vector<LabelCount> result;
  const auto add = [&](const LoadedLabels& loaded) {
    for (LabelCount& count : count_labels(loaded.volume, segments_)) result.push_back(std::move(count));
  };
  if (source_) {
    std::set<double> numbers;  // including segments that others hide when all are read
    for (const LabelCount& label : count_labels(labels().volume, segments_)) numbers.insert(label.value);
    for (const SegmentName& segment : segments_) numbers.insert(segment.value);
    for (const double number : numbers) add(read({.label = number}));
    return result;
  }
  for (const StructureRegion& region : regions_) {
    try {
      add(read({.label = region.name.value}));
    } catch (const Error&) {
      continue;  // points and lines have no volume
    }
  }
  if (result.empty()) labels_of_regions(regions_, {}, path_);  // throws the Error with the reason
  return result;
}

}  // namespace simplexseg
