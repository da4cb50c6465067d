// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_segments.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include "core/number_text.h"
#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_position.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_stack.h"
#include "io/source/stored_header.h"

namespace simplexseg {
namespace {

constexpr int kMaxParts = 20;        ///< largest number of slice distances in the smallest gap between frames
constexpr double kUneven = 0.02;     ///< largest deviation from a multiple of the slice distance, in slice distances
constexpr double kMaxMissing = 1e5;  ///< largest number of slices without a frame in a row

bool are_multiples(const std::vector<double>& gaps, double distance) {
  return std::all_of(gaps.begin(), gaps.end(), [&](double gap) {
    const double count = gap / distance;
    return count > 0.5 && std::abs(count - std::round(count)) <= kUneven;
  });
}

/// Returns the slice distance of frames that are `gaps` apart, mm: Spacing Between Slices if all gaps are multiples of
/// it. Otherwise, of unequal gaps, the slice thickness if all are multiples of it, because slices without a frame are
/// then missing between others; else the greatest distance of which all gaps are multiples, or the smallest gap. Equal
/// gaps are themselves the slice distance.
double slice_distance(const std::vector<double>& gaps, const DicomSlice& slice) {
  const double smallest = *std::min_element(gaps.begin(), gaps.end());
  const double stated = std::abs(slice.slice_distance_mm.value_or(0)), thickness = slice.thickness_mm.value_or(0);
  if (stated > 0 && are_multiples(gaps, stated)) return stated;
  const bool equal = *std::max_element(gaps.begin(), gaps.end()) < (1 + kUneven) * smallest;
  if (!equal && thickness > 0 && are_multiples(gaps, thickness)) return thickness;
  for (int parts = 1; parts <= kMaxParts; ++parts)
    if (are_multiples(gaps, smallest / parts)) return smallest / parts;
  return smallest;
}

/// Returns one slice per position, sorted by position. Slices for positions without a frame have an empty file name.
std::vector<DicomSlice> whole_stack(std::vector<DicomSlice> slices, const std::string& series_name,
                                    std::vector<std::string>& warnings) {
  const Eigen::Vector3d normal = slice_normal(slices.front());
  const double same_mm = same_position_mm(slices);
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::stable_sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const auto last = std::unique(slices.begin(), slices.end(),
                                [&](const auto& a, const auto& b) { return place(b) - place(a) <= same_mm; });
  slices.erase(last, slices.end());
  if (slices.size() == 1) return slices;
  std::vector<double> gaps;
  for (std::size_t i = 1; i < slices.size(); ++i) gaps.push_back(place(slices[i]) - place(slices[i - 1]));
  const double step = slice_distance(gaps, slices.front());
  const double thickness = slices.front().thickness_mm.value_or(0);
  if (!slices.front().slice_distance_mm && thickness > 0 && std::abs(step - thickness) > kUneven * step)
    warnings.push_back("the distance of the slices is not stated: " + length_text(step) +
                       " between the frames is used, although the slices are " + length_text(thickness) + " thick");
  std::vector<DicomSlice> whole;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (i > 0) {
      const Eigen::Vector3d from = *slices[i - 1].position, to = *slices[i].position;
      const double count = std::round(gaps[i - 1] / step);
      if (count > kMaxMissing)
        throw Error("cannot read " + series_name, "its frames are too far apart", "export it again");
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
  const Eigen::Vector3d normal = slice_normal(whole.front());
  const auto along = [&](const DicomSlice& s) { return normal.dot(*s.position - *whole.front().position); };
  const double step = whole.size() > 1 ? along(whole.back()) / double(whole.size() - 1) : 1;
  std::vector<std::size_t> indices;
  indices.reserve(slices.size());
  for (const DicomSlice& s : slices)
    indices.push_back(
        std::clamp<std::size_t>(std::size_t(std::max(0.0, std::round(along(s) / step))), 0, whole.size() - 1));
  return indices;
}

/// Frames of a segmentation with their places in the volume.
struct SegmentFrames {
  std::vector<DicomSlice> slices;
  std::vector<std::size_t> indices;  ///< slice index of each frame
  VolumeInfo info;
};

/// Reads all segments or, if `segment` is given, one alone. Adds the number of voxels that lie in several segments to
/// `shared`.
Volume read_segments(const SegmentFrames& segments, std::optional<int> segment, std::size_t& shared) {
  const VolumeInfo& info = segments.info;
  Volume volume(info.geometry, info.type);
  const std::size_t count = info.geometry.voxel_count() / static_cast<std::size_t>(info.geometry.size[2]);
  std::vector<std::uint16_t> frame(count);
  std::vector<DicomSlice> chosen;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < segments.slices.size(); ++i) {
    if (segment && segments.slices[i].segment != *segment) continue;
    chosen.push_back(segments.slices[i]), indices.push_back(segments.indices[i]);
  }
  DicomFrames frames(chosen);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const DicomSlice& s = chosen[i];
    frames.read(s, VoxelType::UInt16, frame.data());
    visit_voxel_type(info.type, [&]<class T>(std::type_identity<T>) {
      T* to = volume.voxels<T>().data() + indices[i] * count;
      for (std::size_t v = 0; v < count; ++v) {
        const bool inside = s.segmentation == "FRACTIONAL" ? 2 * frame[v] >= s.fraction_max
                            : s.segmentation == "LABELMAP" ? frame[v] != s.background && frame[v] != 0
                                                           : frame[v] != 0;
        const T label = static_cast<T>(!inside ? 0 : s.segmentation == "LABELMAP" ? frame[v] : s.segment);
        shared += label != T(0) && to[v] != T(0) && to[v] != label;
        to[v] = std::max(to[v], label);
      }
    });
  }
  return volume;
}

/// Returns true when several segments have a frame for one slice.
bool share_slices(const SegmentFrames& segments) {
  std::vector<int> owner(static_cast<std::size_t>(segments.info.geometry.size[2]), 0);
  for (std::size_t i = 0; i < segments.slices.size(); ++i) {
    const DicomSlice& s = segments.slices[i];
    int& segment = owner[segments.indices[i]];
    if (s.segmentation != "LABELMAP" && segment != 0 && segment != s.segment) return true;
    segment = s.segment;
  }
  return false;
}

/// Adds the readers of the voxels to `source`.
void add_readers(VolumeSource& source, SegmentFrames frames) {
  const auto segments = std::make_shared<const SegmentFrames>(std::move(frames));
  const auto warnings = std::make_shared<std::vector<std::string>>();
  source.voxel_warnings = warnings;
  source.read = [segments, warnings] {
    std::size_t shared = 0;
    Volume volume = read_segments(*segments, std::nullopt, shared);
    warnings->clear();
    if (shared > 0)
      warnings->push_back(
          counted(static_cast<std::int64_t>(shared),
                  "voxel belongs to several segments and is assigned to the one with the highest number",
                  "voxels belong to several segments and are assigned to the one with the highest number"));
    return volume;
  };
  if (!share_slices(*segments)) return;
  source.read_segment = [segments](int segment) {
    std::size_t shared = 0;
    return read_segments(*segments, segment, shared);
  };
}

}  // namespace

bool is_segmentation(const DicomSlice& slice) { return !slice.segmentation.empty(); }

VolumeSource open_segments(std::vector<DicomSlice> slices, const std::string& series_name) {
  VolumeSource source;
  VolumeInfo& info = source.info;
  require_one_stack(slices, series_name);
  int max_label = 0;
  bool fractional = false;
  for (const DicomSlice& s : slices) {
    max_label = std::max(max_label,
                         s.segmentation == "LABELMAP" ? (1 << std::clamp(s.pixels.stored_bits, 1, 16)) - 1 : s.segment);
    fractional = fractional || s.segmentation == "FRACTIONAL";
    if (s.segment < 1 && s.segmentation != "LABELMAP")
      throw Error("cannot read " + series_name, name_of(s) + " has no segment number", "export it again");
  }
  info.type = max_label > 255 ? VoxelType::UInt16 : VoxelType::UInt8;
  std::vector<DicomSlice> whole = whole_stack(slices, series_name, info.warnings);
  const DicomSlice& first = slices.front();
  info.geometry.size = {first.pixels.columns, first.pixels.rows, static_cast<int>(whole.size())};
  if (first.spacing_mm)
    info.geometry.spacing_mm.head<2>() = *first.spacing_mm;
  else
    info.warnings.push_back("no pixel spacing: 1 mm is assumed");
  if (whole.size() == 1) {
    const double stated = std::abs(first.slice_distance_mm.value_or(0));
    const double thick = stated > 0 ? stated : first.thickness_mm.value_or(0);
    if (thick > 0) info.geometry.spacing_mm[2] = thick;
  }
  stack(whole, info.geometry, info.warnings, series_name);
  std::vector<std::size_t> indices = slice_indices(slices, whole);
  std::set<int> named;
  for (const DicomSlice& s : slices) {
    for (const SegmentName& segment : *s.segments) {
      if (named.insert(segment.value).second) info.segments.push_back(segment);
    }
  }
  if (fractional) info.warnings.push_back("fractional segments include voxels that are at least half filled");
  info.geometry.validate("cannot read " + series_name);
  if (!first.frame_of_reference.empty()) keep_header(info.geometry, DicomFrame{first.frame_of_reference});
  source.extra_bytes = buffer_bytes(first.pixels);
  add_readers(source, {std::move(slices), std::move(indices), info});
  return source;
}

}  // namespace simplexseg
