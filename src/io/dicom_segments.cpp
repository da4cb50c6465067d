// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_segments.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "io/dicom_pixels.h"
#include "io/dicom_stack.h"
#include "io/quiet_libraries.h"

namespace simplexseg {
namespace {

constexpr double kSameMm = 0.01;

/// Slices of distinct places in their order, with those that have no frame put between them, which have no file.
std::vector<DicomSlice> whole_stack(std::vector<DicomSlice> slices, const std::string& what) {
  const Eigen::Vector3d normal = slices.front().axes->col(0).cross(slices.front().axes->col(1)).normalized();
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const auto last = std::unique(slices.begin(), slices.end(),
                                [&](const auto& a, const auto& b) { return place(b) - place(a) < kSameMm; });
  slices.erase(last, slices.end());
  double least = slices.size() > 1 ? place(slices[1]) - place(slices[0]) : 0;
  for (std::size_t i = 2; i < slices.size(); ++i) least = std::min(least, place(slices[i]) - place(slices[i - 1]));
  // Every other slice can be without a frame: the distance that the file names is then the smaller one.
  const double named = slices.front().between_mm.value_or(0);
  const double step = named > 0 && std::abs(least / named - std::round(least / named)) < 0.02 ? named : least;
  std::vector<DicomSlice> whole;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    if (i > 0) {
      const Eigen::Vector3d from = *slices[i - 1].position, to = *slices[i].position;
      const double count = std::round((place(slices[i]) - place(slices[i - 1])) / step);
      if (count > 100000) throw Error("cannot read " + what, "its frames lie too far apart", "export it again");
      for (int k = 1; k < static_cast<int>(count); ++k) {
        DicomSlice none = slices[i];
        none.file.clear();
        none.position = from + (to - from) * (k / count);
        whole.push_back(none);
      }
    }
    whole.push_back(slices[i]);
  }
  return whole;
}

/// Where each frame lies in the stack, by its place along the normal.
std::vector<std::size_t> layers_of(const std::vector<DicomSlice>& slices, const std::vector<DicomSlice>& whole) {
  const Eigen::Vector3d normal = whole.front().axes->col(0).cross(whole.front().axes->col(1)).normalized();
  const auto along = [&](const DicomSlice& s) { return normal.dot(*s.position - *whole.front().position); };
  const double step = whole.size() > 1 ? along(whole.back()) / double(whole.size() - 1) : 1;
  std::vector<std::size_t> layers;
  layers.reserve(slices.size());
  for (const DicomSlice& s : slices)
    layers.push_back(
        std::clamp<std::size_t>(std::size_t(std::max(0.0, std::round(along(s) / step))), 0, whole.size() - 1));
  return layers;
}

Volume read_segments(const std::vector<DicomSlice>& slices, const std::vector<std::size_t>& layers,
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
      T* to = volume.voxels<T>().data() + layers[i] * count;
      for (std::size_t v = 0; v < count; ++v) {
        const bool inside = s.segmentation == "FRACTIONAL" ? 2 * frame[v] >= s.fraction_most : frame[v] != 0;
        const int label = !inside ? 0 : s.segmentation == "LABELMAP" ? frame[v] : s.segment;
        to[v] = std::max(to[v], static_cast<T>(label));
      }
    });
  }
  return volume;
}

}  // namespace

bool is_segmentation(const DicomSlice& slice) { return !slice.segmentation.empty(); }

VolumeSource open_segments(std::vector<DicomSlice> slices, const std::string& what) {
  VolumeSource source;
  VolumeInfo& info = source.info;
  require_one_stack(slices, what);
  int most = 0;
  bool fractional = false, overlaps = false;
  for (const DicomSlice& s : slices) {
    most =
        std::max(most, s.segmentation == "LABELMAP" ? (1 << std::clamp(s.pixels.stored_bits, 1, 16)) - 1 : s.segment);
    fractional = fractional || s.segmentation == "FRACTIONAL";
    if (s.segment < 1 && s.segmentation != "LABELMAP")
      throw Error("cannot read " + what, name_of(s) + " does not say which segment it shows", "export it again");
  }
  info.type = most > 255 ? VoxelType::UInt16 : VoxelType::UInt8;
  std::vector<DicomSlice> whole = whole_stack(slices, what);
  const DicomSlice& first = slices.front();
  info.geometry.size = {first.pixels.columns, first.pixels.rows, static_cast<int>(whole.size())};
  if (first.spacing_mm)
    info.geometry.spacing_mm.head<2>() = *first.spacing_mm;
  else
    info.warnings.push_back("no pixel spacing: 1 mm is assumed");
  if (whole.size() == 1) {
    const double thick = first.between_mm.value_or(0) > 0 ? *first.between_mm : first.thickness_mm.value_or(0);
    if (thick > 0) info.geometry.spacing_mm[2] = thick;
  }
  stack(whole, info.geometry, info.warnings, what);
  std::set<std::size_t> taken;
  std::vector<std::size_t> layers = layers_of(slices, whole);
  for (const std::size_t layer : layers) overlaps = !taken.insert(layer).second || overlaps;
  if (overlaps && slices.front().overlap)
    info.warnings.push_back("where segments overlap, the one of the highest number is taken");
  std::set<int> named;
  for (const DicomSlice& s : slices) {
    for (const SegmentName& segment : *s.segments) {
      if (named.insert(segment.value).second) info.segments.push_back(segment);
    }
  }
  if (fractional) info.warnings.push_back("a segment is taken where it fills at least half of a voxel");
  info.geometry.validate("cannot read " + what);
  source.extra_bytes = buffer_bytes(first.pixels);
  source.read = [slices = std::move(slices), layers = std::move(layers), info] {
    return read_segments(slices, layers, info);
  };
  return source;
}

}  // namespace simplexseg
