// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_frames.h"

#include <gdcmDataSet.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "io/dicom/dicom_values.h"

namespace simplexseg {
namespace {

constexpr DicomTag kShared{0x5200, 0x9229}, kPerFrame{0x5200, 0x9230}, kDimensions{0x0020, 0x9222},
    kFrameContent{0x0020, 0x9111}, kStackId{0x0020, 0x9056}, kInStack{0x0020, 0x9057};

struct Trait {
  DicomTag sequence;  ///< functional group with the attribute; {0, 0}: attribute of the image itself
  DicomTag tag;
  DicomKind kind;
  const char* name;
};
/// Attributes that can distinguish the volumes of a series, the most likely first.
constexpr Trait kTraits[] = {
    {kFrameContent, {0x0020, 0x9128}, DicomKind::Long, "temporal position"},
    {{}, {0x0020, 0x0100}, DicomKind::Text, "temporal position"},
    {{0x0018, 0x9117}, {0x0018, 0x9087}, DicomKind::Double, "b-value"},
    {{}, {0x0018, 0x9087}, DicomKind::Double, "b-value"},
    {{0x0018, 0x9114}, {0x0018, 0x9082}, DicomKind::Double, "echo time"},
    {{}, {0x0018, 0x0081}, DicomKind::Text, "echo time"},
    {{}, {0x0018, 0x0082}, DicomKind::Text, "inversion time"},
    {{}, {0x0018, 0x1314}, DicomKind::Text, "flip angle"},
    {{0x0018, 0x9118}, {0x0020, 0x9153}, DicomKind::Double, "trigger delay"},
    {{}, {0x0018, 0x1060}, DicomKind::Text, "trigger time"},
    {{}, {0x0054, 0x1300}, DicomKind::Text, "frame reference time"},
    {{0x0018, 0x9226}, {0x0008, 0x9007}, DicomKind::Text, "frame type"},
    {{}, {0x0008, 0x0008}, DicomKind::Text, "image type"},
    {kFrameContent, kStackId, DicomKind::Text, "stack"},
    {{}, {0x0020, 0x0012}, DicomKind::Text, "acquisition number"},
    {{}, {0x0008, 0x0032}, DicomKind::Text, "acquisition time"},
};

std::string value_of(const gdcm::DataSet& data, const Trait& trait) {
  if (trait.kind == DicomKind::Text) return text_of(data, trait.tag);
  std::ostringstream text;
  if (const auto number = number_of(data, trait.tag, trait.kind)) text << *number;
  return text.str();
}

void add_trait(DicomSlice& slice, const std::string& name, const std::string& value) {
  if (value.empty()) return;
  for (auto& [known, old] : slice.traits) {
    if (known == name) {
      old = value;
      return;
    }
  }
  slice.traits.emplace_back(name, value);
}

/// Returns the name of each dimension index. The name is empty for an index of positions, because the positions
/// themselves are used.
std::vector<std::string> dimension_names(const gdcm::DataSet& data) {
  std::vector<std::string> names;
  each_item(data, kDimensions, [&](const gdcm::DataSet& item) {
    const std::vector<double> at = numbers_of(item, {0x0020, 0x9165}, DicomKind::Short);
    std::string name = text_of(item, {0x0020, 0x9421}, 40);
    const auto is = [&](DicomTag tag) { return at.size() == 2 && at[0] == tag.group && at[1] == tag.element; };
    if (is(kInStack) || is({0x0020, 0x0032}) || is({0x0020, 0x9301})) {
      name.clear();
    } else if (const auto* known = std::find_if(std::begin(kTraits), std::end(kTraits),
                                                [&](const Trait& trait) { return is(trait.tag); });
               known != std::end(kTraits)) {
      name = known->name;
    } else if (name.empty()) {
      name = "dimension " + std::to_string(names.size() + 1);
    }
    names.push_back(name);
  });
  return names;
}

/// Copies the functional groups of one frame, or those shared by all frames, to `slice`.
void read_functional_groups(const gdcm::DataSet& groups, const std::vector<std::string>& dimensions,
                            DicomSlice& slice) {
  const auto read_plane = [&](const gdcm::DataSet& data) { read_image_plane(data, slice); };
  for (const DicomTag sequence : {DicomTag{0x0020, 0x9113}, {0x0020, 0x9116}, {0x0028, 0x9110}})
    first_item(groups, sequence, read_plane);
  for (const DicomTag sequence : {DicomTag{0x0020, 0x930e}, {0x0020, 0x930f}}) {
    if (first_item(groups, sequence, read_plane))
      slice.assumed = "positions are relative to the ultrasound probe: the patient's left and right are unknown";
  }
  first_item(groups, {0x0028, 0x9145}, [&](const gdcm::DataSet& data) {
    if (const auto n = number_of(data, {0x0028, 0x1053}); n && *n != 0) slice.slope = *n;
    if (const auto n = number_of(data, {0x0028, 0x1052})) slice.intercept = *n;
  });
  first_item(groups, {0x0062, 0x000a}, [&](const gdcm::DataSet& data) {
    slice.segment = short_of(data, {0x0062, 0x000b}, 0);
  });
  first_item(groups, kFrameContent, [&](const gdcm::DataSet& data) {
    const std::vector<double> indices = numbers_of(data, {0x0020, 0x9157}, DicomKind::Long);
    for (std::size_t d = 0; d < indices.size() && d < dimensions.size(); ++d) {
      if (!dimensions[d].empty()) add_trait(slice, dimensions[d], std::to_string(std::lround(indices[d])));
    }
  });
  for (const Trait& trait : kTraits) {
    if (trait.sequence.group != 0) {
      first_item(groups, trait.sequence,
                 [&](const gdcm::DataSet& data) { add_trait(slice, trait.name, value_of(data, trait)); });
    }
  }
}

/// Copies the functional groups to the frames; returns true when they contain positions.
bool apply_functional_groups(const gdcm::DataSet& data, std::vector<DicomSlice>& frames) {
  if (!has(data, kShared) && !has(data, kPerFrame)) return false;
  const std::vector<std::string> dimensions = dimension_names(data);
  first_item(data, kShared, [&](const gdcm::DataSet& groups) {
    for (DicomSlice& frame : frames) read_functional_groups(groups, dimensions, frame);
  });
  std::size_t next = 0;
  each_item(data, kPerFrame, [&](const gdcm::DataSet& groups) {
    if (next < frames.size()) read_functional_groups(groups, dimensions, frames[next++]);
  });
  return frames.front().position.has_value();
}

Eigen::Vector3d normal_of(const DicomSlice& slice) { return slice.axes->col(0).cross(slice.axes->col(1)).normalized(); }

/// Places the frames of a dose grid. The offsets of the grid are distances along the normal or, if the first offset
/// equals the z coordinate of the image position, z coordinates, mm. Returns false when there are no such offsets.
bool apply_dose_offsets(const gdcm::DataSet& data, std::vector<DicomSlice>& frames) {
  const std::vector<double> offsets = numbers_of(data, {0x3004, 0x000c});
  const DicomSlice& first = frames.front();
  if (offsets.size() != frames.size() || !first.position || !first.axes) return false;
  const Eigen::Vector3d from = *first.position, normal = normal_of(first);
  const bool absolute = offsets[0] != 0 && std::abs(offsets[0] - from.z()) < 1e-3 && std::abs(normal.z()) > 0.999;
  for (std::size_t f = 0; f < frames.size(); ++f)
    frames[f].position = from + (absolute ? (offsets[f] - from.z()) * Eigen::Vector3d::UnitZ()
                                          : Eigen::Vector3d((offsets[f] - offsets[0]) * normal));
  return true;
}

/// Reads the vectors to which the frame increment pointer refers: slice, detector, time slot etc. of each frame.
/// Returns false when there are none.
bool apply_frame_vectors(const gdcm::DataSet& data, std::vector<DicomSlice>& frames) {
  const std::vector<double> named = numbers_of(data, {0x0028, 0x0009}, DicomKind::Short);
  bool sliced = false, any = false;
  std::vector<double> slice_of(frames.size(), 1);
  for (std::size_t i = 0; i + 1 < named.size(); i += 2) {
    const auto element = static_cast<std::uint16_t>(named[i + 1]);
    if (named[i] != 0x0054) continue;
    const std::vector<double> vector = numbers_of(data, {0x0054, element}, DicomKind::Short);
    if (vector.size() != frames.size()) continue;
    any = true;
    if (element == 0x0080) {
      sliced = true;
      slice_of = vector;
      continue;
    }
    const char* name = element == 0x0010   ? "energy window"
                       : element == 0x0020 ? "detector"
                       : element == 0x0070 ? "time slot"
                                           : "view or phase";
    for (std::size_t f = 0; f < frames.size(); ++f) add_trait(frames[f], name, std::to_string(std::lround(vector[f])));
  }
  first_item(data, {0x0054, 0x0022}, [&](const gdcm::DataSet& detector) {
    for (DicomSlice& frame : frames) read_image_plane(detector, frame);
  });
  if (!any) return false;
  const DicomSlice first = frames.front();
  const double step = first.slice_distance_mm.value_or(first.thickness_mm.value_or(0));
  for (std::size_t f = 0; sliced && f < frames.size(); ++f) {
    if (first.position && first.axes && step > 0) {
      frames[f].position = *first.position + (slice_of[f] - 1) * step * normal_of(first);
      frames[f].assumed =
          "the slices are assumed to be evenly spaced along their normal; the file has no slice positions";
    } else {
      frames[f].position.reset();
    }
  }
  return true;
}

/// Returns true when frames without positions are time points at one position.
bool are_time_points(const gdcm::DataSet& data, const DicomSlice& whole) {
  const std::vector<double> named = numbers_of(data, {0x0028, 0x0009}, DicomKind::Short);
  if (named.size() >= 2 && named[0] == 0x0018 && (named[1] == 0x1063 || named[1] == 0x1065)) return true;
  constexpr const char* kTimeModalities[] = {"US", "IVUS", "XA", "RF", "ES"};
  return std::any_of(std::begin(kTimeModalities), std::end(kTimeModalities),
                     [&](const char* m) { return whole.modality == m; });
}

}  // namespace

void read_image_plane(const gdcm::DataSet& data, DicomSlice& slice) {
  const auto first_of = [&](DicomTag patient, DicomTag volume, std::size_t count) {
    std::vector<double> n = numbers_of(data, patient);
    if (n.size() < count) n = numbers_of(data, volume, DicomKind::Double);
    return n.size() < count ? std::vector<double>() : n;
  };
  if (const auto n = first_of({0x0020, 0x0032}, {0x0020, 0x9301}, 3); !n.empty())
    slice.position = Eigen::Vector3d(n[0], n[1], n[2]);
  if (const auto n = first_of({0x0020, 0x0037}, {0x0020, 0x9302}, 6); !n.empty()) {
    Eigen::Matrix<double, 3, 2> axes;
    axes << n[0], n[3], n[1], n[4], n[2], n[5];
    // The axes are normalised because files store few digits. Axes that are not orthogonal are ignored.
    if (axes.col(0).norm() > 0.5 && axes.col(1).norm() > 0.5) {
      axes.colwise().normalize();
      if (std::abs(axes.col(0).dot(axes.col(1))) < 0.1) slice.axes = axes;
    }
  }
  for (const DicomTag tag : {DicomTag{0x0028, 0x0030}, {0x0018, 0x1164}}) {
    // Pixel Spacing, else Imager Pixel Spacing: first the distance between rows, then between columns, mm.
    const std::vector<double> n = numbers_of(data, tag);
    if (n.size() < 2 || n[0] <= 0 || n[1] <= 0) continue;
    slice.spacing_mm = Eigen::Vector2d(n[1], n[0]);
    break;
  }
  if (const auto n = number_of(data, {0x0018, 0x0088})) slice.slice_distance_mm = std::abs(*n);
  if (const auto n = number_of(data, {0x0018, 0x0050})) slice.thickness_mm = *n;
}

std::vector<DicomSlice> frames_of(const gdcm::DataSet& data, const DicomSlice& whole) {
  std::vector<DicomSlice> frames(static_cast<std::size_t>(whole.pixels.frames), whole);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    frames[f].frame = static_cast<int>(f);
    for (const Trait& trait : kTraits) {
      if (trait.sequence.group == 0) add_trait(frames[f], trait.name, value_of(data, trait));
    }
  }
  if (apply_functional_groups(data, frames) || apply_dose_offsets(data, frames) || apply_frame_vectors(data, frames))
    return frames;
  if (frames.size() == 1) return frames;
  const bool time_series = are_time_points(data, whole);
  for (DicomSlice& frame : frames) {
    if (time_series) {
      add_trait(frame, "time", std::to_string(frame.frame + 1));
      continue;
    }
    frame.position.reset();
    frame.assumed = "its " + std::to_string(frames.size()) +
                    " frames have no positions: they are assumed to be evenly spaced slices in file order";
  }
  return frames;
}

}  // namespace simplexseg
