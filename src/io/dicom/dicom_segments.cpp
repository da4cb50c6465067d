// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_segments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_stack.h"
#include "io/platform/quiet_libraries.h"

namespace simplexseg {
namespace {

constexpr double kSamePositionMm = 0.01;

/// Returns one slice per position, sorted by position. Slices for positions without a frame have an empty file name.
std::vector<DicomSlice> whole_stack(std::vector<DicomSlice> slices, const std::string& series_name) {
  const Eigen::Vector3d normal = slices.front().axes->col(0).cross(slices.front().axes->col(1)).normalized();
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const auto last = std::unique(slices.begin(), slices.end(),
                                [&](const auto& a, const auto& b) { return place(b) - place(a) < kSamePositionMm; });
  slices.erase(last, slices.end());
  double min_gap = slices.size() > 1 ? place(slices[1]) - place(slices[0]) : 0;
  for (std::size_t i = 2; i < slices.size(); ++i) min_gap = std::min(min_gap, place(slices[i]) - place(slices[i - 1]));
  // Frames can be missing at every other position. The slice distance in the header is therefore used if the smallest
  // distance between frames is a multiple of it.
  const double named = slices.front().slice_distance_mm.value_or(0);
  const double step = named > 0 && std::abs(min_gap / named - std::round(min_gap / named)) < 0.02 ? named : min_gap;
  std::vector<DicomSlice> whole;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (i > 0) {
      const Eigen::Vector3d from = *slices[i - 1].position, to = *slices[i].position;
      const double count = std::round((place(slices[i]) - place(slices[i - 1])) / step);
      if (count > 100000) throw Error("cannot read " + series_name, "its frames are too far apart", "export it again");
      for (int k = 1; k < static_cast<int>(count); ++k) {
        DicomSlice empty = slices[i];
        empty.file.clear();
        empty.position = from + (to - from) * (k / count);
        whole.push_back(empty);
      }
    }
    whole.push_back(slices[i]);
  }
  return whole;
}

/// Returns the slice index of each frame in the stack `whole`, from the position of the frame along the normal.
std::vector<std::size_t> slice_indices(const std::vector<DicomSlice>& slices, const std::vector<DicomSlice>& whole) {
  const Eigen::Vector3d normal = whole.front().axes->col(0).cross(whole.front().axes->col(1)).normalized();
  const auto along = [&](const DicomSlice& s) { return normal.dot(*s.position - *whole.front().position); };
  const double step = whole.size() > 1 ? along(whole.back()) / double(whole.size() - 1) : 1;
  std::vector<std::size_t> indices;
  indices.reserve(slices.size());
  for (const DicomSlice& s : slices)
    indices.push_back(
        std::clamp<std::size_t>(std::size_t(std::max(0.0, std::round(along(s) / step))), 0, whole.size() - 1));
  return indices;
}

Volume read_segments(const std::vector<DicomSlice>& slices, const std::vector<std::size_t>& indices,
                     const VolumeInfo& info) {
  const QuietLibraries quiet;
  Volume volume(info.geometry, info.type);
  const std::size_t count = info.geometry.voxel_count() / static_cast<std::size_t>(info.geometry.size[2]);
  std::vector<std::uint16_t> frame(count);
  DicomFrames frames(slices);
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const DicomSlice& s = slices[i];
    frames.read(s, VoxelType::UInt16, frame.data());
    visit_voxel_type(info.type, [&]<class T>(std::type_identity<T>) {
      T* to = volume.voxels<T>().data() + indices[i] * count;
      for (std::size_t v = 0; v < count; ++v) {
        const bool inside = s.segmentation == "FRACTIONAL" ? 2 * frame[v] >= s.fraction_max : frame[v] != 0;
        const int label = !inside ? 0 : s.segmentation == "LABELMAP" ? frame[v] : s.segment;
        to[v] = std::max(to[v], static_cast<T>(label));
      }
    });
  }
  return volume;
}

}  // namespace

bool is_segmentation(const DicomSlice& slice) { return !slice.segmentation.empty(); }

VolumeSource open_segments(std::vector<DicomSlice> slices, const std::string& series_name) {
  VolumeSource source;
  VolumeInfo& info = source.info;
  require_one_stack(slices, series_name);
  int max_label = 0;
  bool fractional = false, overlaps = false;
  for (const DicomSlice& s : slices) {
    max_label = std::max(max_label,
                         s.segmentation == "LABELMAP" ? (1 << std::clamp(s.pixels.stored_bits, 1, 16)) - 1 : s.segment);
    fractional = fractional || s.segmentation == "FRACTIONAL";
    if (s.segment < 1 && s.segmentation != "LABELMAP")
      throw Error("cannot read " + series_name, name_of(s) + " has no segment number", "export it again");
  }
  info.type = max_label > 255 ? VoxelType::UInt16 : VoxelType::UInt8;
  std::vector<DicomSlice> whole = whole_stack(slices, series_name);
  const DicomSlice& first = slices.front();
  info.geometry.size = {first.pixels.columns, first.pixels.rows, static_cast<int>(whole.size())};
  if (first.spacing_mm)
    info.geometry.spacing_mm.head<2>() = *first.spacing_mm;
  else
    info.warnings.push_back("no pixel spacing: 1 mm is assumed");
  if (whole.size() == 1) {
    const double stated = first.slice_distance_mm.value_or(0);
    const double thick = stated > 0 ? stated : first.thickness_mm.value_or(0);
    if (thick > 0) info.geometry.spacing_mm[2] = thick;
  }
  stack(whole, info.geometry, info.warnings, series_name);
  std::set<std::size_t> used;
  std::vector<std::size_t> indices = slice_indices(slices, whole);
  for (const std::size_t index : indices) overlaps = !used.insert(index).second || overlaps;
  if (overlaps && slices.front().may_overlap)
    info.warnings.push_back("where segments overlap, the highest segment number is used");
  std::set<int> named;
  for (const DicomSlice& s : slices) {
    for (const SegmentName& segment : *s.segments) {
      if (named.insert(segment.value).second) info.segments.push_back(segment);
    }
  }
  if (fractional) info.warnings.push_back("fractional segments include voxels that are at least half filled");
  info.geometry.validate("cannot read " + series_name);
  source.extra_bytes = buffer_bytes(first.pixels);
  source.read = [slices = std::move(slices), indices = std::move(indices), info] {
    return read_segments(slices, indices, info);
  };
  return source;
}

}  // namespace simplexseg
