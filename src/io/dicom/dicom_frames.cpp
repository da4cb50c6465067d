// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_frames.h"

#include <gdcmDataSet.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "io/dicom/dicom_position.h"
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

/// Returns the value as text; empty when the attribute is missing or its bytes are no number.
std::string value_of(const gdcm::DataSet& data, const Trait& trait) {
  if (trait.kind == DicomKind::Text) return text_of(data, trait.tag);
  try {
    const auto number = number_of(data, trait.tag, trait.kind);
    return number ? general_text(*number, 6) : "";
  } catch (const InvalidElement&) {
    return {};
  }
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
  first_item(groups, {0x0028, 0x9145}, [&](const gdcm::DataSet& data) { read_rescaling(data, slice); });
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

/// Copies the functional groups to the frames; returns true when they contain the positions of several frames, or of
/// all. Otherwise all frames have the position of the first, if it has one.
bool apply_functional_groups(const gdcm::DataSet& data, std::vector<DicomSlice>& frames) {
  if (!has(data, kShared) && !has(data, kPerFrame)) return false;
  const std::vector<std::string> dimensions = dimension_names(data);
  const std::optional<Eigen::Vector3d> of_image = frames.front().position;
  for (DicomSlice& frame : frames) frame.position.reset();
  first_item(data, kShared, [&](const gdcm::DataSet& groups) {
    for (DicomSlice& frame : frames) read_functional_groups(groups, dimensions, frame);
  });
  std::size_t next = 0;
  each_item(data, kPerFrame, [&](const gdcm::DataSet& groups) {
    if (next < frames.size()) read_functional_groups(groups, dimensions, frames[next++]);
  });
  const auto placed = static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [](const DicomSlice& frame) { return frame.position.has_value(); }));
  if (placed == frames.size() || placed > 1 || (placed == 1 && !frames.front().position)) return true;
  const std::optional<Eigen::Vector3d> first = placed == 1 ? frames.front().position : of_image;
  for (DicomSlice& frame : frames) frame.position = first;
  return false;
}

/// Returns the stated distance of neighbouring slices, else their thickness; 0 when unknown, mm.
double step_of(const DicomSlice& slice) {
  const double distance = slice.slice_distance_mm.value_or(0), thickness = slice.thickness_mm.value_or(0);
  return distance > 0 ? distance : std::max(thickness, 0.0);
}

/// Returns true for nuclear medicine, where the sign of Spacing Between Slices is the direction of stacking.
bool is_nuclear_medicine(const DicomSlice& slice) {
  return slice.modality == "NM" || slice.sop_class == "1.2.840.10008.5.1.4.1.1.20" ||
         slice.sop_class == "1.2.840.10008.5.1.4.1.1.5";
}

/// Places the frames of a dose grid. The offsets of the grid are distances along the normal or, if the first offset
/// equals the z coordinate of the image position, z coordinates, mm. Returns false when there are no such offsets.
bool apply_dose_offsets(const gdcm::DataSet& data, std::vector<DicomSlice>& frames) {
  const std::vector<double> offsets = numbers_of(data, {0x3004, 0x000c});
  const DicomSlice& first = frames.front();
  if (offsets.size() != frames.size() || !first.position || !first.axes) return false;
  const Eigen::Vector3d from = *first.position, normal = slice_normal(first);
  const double step = offsets.size() > 1 ? std::abs(offsets[1] - offsets[0]) : 0;
  const bool absolute = offsets[0] != 0 && std::abs(offsets[0] - from.z()) <= same_position_mm(step, from.norm()) &&
                        std::abs(normal.z()) > 0.999;
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
  const double distance = step_of(first);
  const double step = first.stacked_backwards ? -distance : distance;
  for (std::size_t f = 0; sliced && f < frames.size(); ++f) {
    if (first.position && first.axes && distance > 0) {
      frames[f].position = *first.position + (slice_of[f] - 1) * step * slice_normal(first);
      if (first.slice_distance_mm.value_or(0) <= 0)
        frames[f].assumed = "the distance of the slices is assumed to be their thickness; the file does not state it";
    } else {
      frames[f].position.reset();
    }
  }
  return true;
}

/// Places frames without positions as slices in file order, along the normal of the first frame if that is known.
void assume_slices(std::vector<DicomSlice>& frames) {
  const DicomSlice first = frames.front();
  const bool placed = first.position && first.axes;
  const double stated = step_of(first), distance = stated > 0 ? stated : 1;
  std::string assumed = "its " + std::to_string(frames.size()) +  // at least 2
                        " frames have no positions: they are assumed to be evenly spaced slices in file order";
  if (placed) assumed += " along the normal of the first frame";
  if (stated <= 0) assumed += ", 1 mm apart";
  const bool backwards = first.stacked_backwards && is_nuclear_medicine(first);
  if (first.stacked_backwards && !backwards)
    assumed +=
        "; the minus sign of Spacing Between Slices (0018,0088) is ignored, because the standard defines it for "
        "nuclear medicine alone";
  for (DicomSlice& frame : frames) {
    if (placed)
      frame.position = *first.position + (backwards ? -distance : distance) * frame.frame * slice_normal(first);
    else
      frame.position.reset();
    frame.assumed = assumed;
  }
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
  const auto ignore = [&](DicomTag tag, const std::string& reason) {
    slice.ignored = "its " + element_name(tag) + " is '" + text_of(data, tag, 60) + "' and is ignored: " + reason;
  };
  const auto first_of = [&](DicomTag patient, DicomTag volume, std::size_t count) {
    const std::vector<double> n = numbers_of(data, patient, DicomKind::Text, count);
    return n.empty() ? numbers_of(data, volume, DicomKind::Double, count) : n;
  };
  if (const auto n = first_of({0x0020, 0x0032}, {0x0020, 0x9301}, 3); !n.empty())
    slice.position = Eigen::Vector3d(n[0], n[1], n[2]);
  if (const auto n = first_of({0x0020, 0x0037}, {0x0020, 0x9302}, 6); !n.empty()) {
    Eigen::Matrix<double, 3, 2> axes;
    axes << n[0], n[3], n[1], n[4], n[2], n[5];
    // The axes are normalised because files store few digits.
    const bool are_directions = axes.col(0).norm() > 0.5 && axes.col(1).norm() > 0.5;
    if (are_directions) axes.colwise().normalize();
    if (are_directions && std::abs(axes.col(0).dot(axes.col(1))) < 0.1)
      slice.axes = axes;
    else
      ignore({0x0020, 0x0037}, "these are no perpendicular directions");
  }
  for (const DicomTag tag : {DicomTag{0x0028, 0x0030}, {0x0018, 0x1164}}) {
    // Pixel Spacing, else Imager Pixel Spacing: first the distance between rows, then between columns, mm.
    const std::vector<double> n = numbers_of(data, tag, DicomKind::Text, 2);
    if (n.empty()) continue;
    if (n[0] < 0 || n[1] < 0) throw_invalid(data, tag, "which is negative");
    if (n[0] == 0 || n[1] == 0) {
      ignore(tag, "a distance of 0 is not possible");
      continue;
    }
    slice.spacing_mm = Eigen::Vector2d(n[1], n[0]);
    break;
  }
  if (const auto n = number_of(data, {0x0018, 0x0088})) {
    slice.slice_distance_mm = std::abs(*n);
    slice.stacked_backwards = *n < 0;
  }
  if (const auto n = number_of(data, {0x0018, 0x0050})) slice.thickness_mm = *n;
}

void read_rescaling(const gdcm::DataSet& data, DicomSlice& slice) {
  const auto read_slope = [&](DicomTag tag) {
    const auto n = number_of(data, tag);
    if (!n) return;
    if (*n == 0)
      slice.ignored = "its " + element_name(tag) + " is 0 and is ignored: all values would be equal";
    else
      slice.slope = *n;
  };
  read_slope({0x0028, 0x1053});
  if (const auto n = number_of(data, {0x0028, 0x1052})) slice.intercept = *n;
  if (slice.modality == "RTDOSE") read_slope({0x3004, 0x000e});
}

bool is_numeric_trait(const std::string& name) {
  constexpr DicomTag kTexts[] = {{0x0008, 0x9007}, {0x0008, 0x0008}, kStackId, {0x0008, 0x0032}};
  return std::any_of(std::begin(kTraits), std::end(kTraits), [&](const Trait& trait) {
    return name == trait.name && std::none_of(std::begin(kTexts), std::end(kTexts), [&](const DicomTag& text) {
             return text.group == trait.tag.group && text.element == trait.tag.element;
           });
  });
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
    if (time_series) add_trait(frame, "time", std::to_string(frame.frame + 1));
  }
  if (!time_series) assume_slices(frames);
  return frames;
}

}  // namespace simplexseg
