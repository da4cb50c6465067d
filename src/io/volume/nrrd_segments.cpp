// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nrrd_segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/source/stored_voxels.h"
#include "io/volume/nrrd_header.h"

namespace simplexseg {
namespace {

constexpr int kMaxSegments = 65535;

std::string prefix_of(std::size_t number) { return "Segment" + std::to_string(number) + "_"; }

std::uint8_t byte_of(double share) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0))); }

/// First and last voxel index along i, along j and along k.
using Extent = std::array<int, 6>;

std::map<int, Extent> extents_of(const Volume& labels) {
  std::map<int, Extent> extents;
  const std::array<int, 3> size = labels.geometry().size;
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const T* voxel = labels.voxels<T>().data();
    int value = 0;
    Extent* extent = nullptr;
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i, ++voxel) {
          if (*voxel == T(0)) continue;
          if (!extent || static_cast<int>(*voxel) != value) {
            value = static_cast<int>(*voxel);
            extent = &extents.try_emplace(value, Extent{i, i, j, j, k, k}).first->second;
          }
          Extent& e = *extent;
          e = {std::min(e[0], i), std::max(e[1], i), std::min(e[2], j),
               std::max(e[3], j), std::min(e[4], k), std::max(e[5], k)};
        }
      }
    }
  });
  return extents;
}

// Tag of the codes of a segment, in the format of 3D Slicer: names of terminologies and codes, separated by tildes
// (https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html).
constexpr std::string_view kTerminology = "TerminologyEntry:";

std::vector<std::string> parts_of(std::string_view text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// Tag with the codes; "" if there are none.
std::string terminology_entry(const SegmentCode& code) {
  if (code.empty()) return "";
  std::string text(kTerminology);
  text += "Segmentation category and type - 3D Slicer General Anatomy list";
  for (const CodedConcept* one : {&code.category, &code.type, &code.modifier})
    text.append("~").append(one->scheme).append("^").append(one->value).append("^").append(one->meaning);
  return text + "~Anatomic codes - DICOM master list~^^~^^|";
}

/// Codes in the tags of a segment; none if they are missing or incomplete.
SegmentCode code_of_tags(const std::string& tags) {
  for (const std::string& tag : parts_of(one_line(tags, 2000), '|')) {
    if (!tag.starts_with(kTerminology)) continue;
    const std::vector<std::string> fields = parts_of(std::string_view(tag).substr(kTerminology.size()), '~');
    if (fields.size() < 3) continue;
    std::array<CodedConcept, 3> codes;
    for (std::size_t c = 0; c < codes.size() && c + 1 < fields.size(); ++c) {
      const std::vector<std::string> parts = parts_of(fields[c + 1], '^');
      if (parts.size() == 3 && !parts[1].empty()) codes[c] = {parts[0], parts[1], parts[2]};
    }
    SegmentCode code{codes[0], codes[1], codes[2]};
    if (!code.empty() && fault_of(code).empty()) return code;
  }
  return {};
}

/// Segment as the header describes it.
struct DescribedSegment {
  SegmentName name;  ///< the number is the label value, or differs from it if values are not distinct
  int value = 0;     ///< label value in the layer
  std::int64_t layer = 0;
};

std::vector<DescribedSegment> described_segments(const NrrdHeader& header) {
  std::vector<DescribedSegment> segments;
  for (std::size_t number = 0; number < kMaxSegments; ++number) {
    const std::string prefix = prefix_of(number);
    const auto value = number_of<std::int32_t>(header.key(prefix + "LabelValue"));
    if (!value) break;
    SegmentName segment{.value = *value, .name = one_line(header.key(prefix + "Name"), 200)};
    if (segment.name.empty()) segment.name = one_line(header.key(prefix + "ID"), 200);
    const std::vector<std::string> colour = words_of(header.key(prefix + "Color"));
    std::array<double, 3> shares{};
    bool known = colour.size() == 3;
    for (std::size_t c = 0; known && c < 3; ++c) {
      const auto share = number_of<double>(colour[c]);
      known = share.has_value() && std::isfinite(*share);
      if (known) shares[c] = *share;
    }
    segment.code = code_of_tags(header.key(prefix + "Tags"));
    if (known) segment.colour = {byte_of(shares[0]), byte_of(shares[1]), byte_of(shares[2])};
    segments.push_back({segment, *value, number_of<std::int64_t>(header.key(prefix + "Layer")).value_or(0)});
  }
  return segments;
}

/// Layers that contain segments.
struct Layers {
  VolumeInfo info;  ///< of the label volume
  std::vector<DescribedSegment> segments;
  std::map<std::int64_t, std::function<Volume()>> readers;  ///< by layer
};

/// Number of voxels with a conflict.
struct LayerFaults {
  std::size_t shared = 0;   ///< in several segments
  std::size_t unnamed = 0;  ///< with a value that no segment has
};

/// Reads all segments or, if `segment` is given, one alone.
Volume read_layers(const Layers& layers, std::optional<int> segment, LayerFaults& faults) {
  Volume labels(layers.info.geometry, layers.info.type);
  for (const auto& [layer, reader] : layers.readers) {
    std::map<double, int> numbers;  // by label value
    for (const DescribedSegment& s : layers.segments)
      if (s.layer == layer && (!segment || s.name.value == *segment)) numbers.emplace(s.value, s.name.value);
    if (numbers.empty()) continue;
    const Volume values = reader();
    visit_voxel_type(values.type(), [&]<class From>(std::type_identity<From>) {
      visit_voxel_type(labels.type(), [&]<class To>(std::type_identity<To>) {
        const std::span<const From> from = values.voxels<From>();
        const std::span<To> to = labels.voxels<To>();
        From last = From(0);
        int number = 0;
        for (std::size_t v = 0; v < to.size(); ++v) {
          if (from[v] == From(0) || from[v] != from[v]) continue;  // NaN is background
          if (from[v] != last) {
            last = from[v];
            const auto found = numbers.find(static_cast<double>(last));
            number = found == numbers.end() ? 0 : found->second;
          }
          faults.unnamed += number == 0;
          faults.shared += number != 0 && to[v] != To(0);
          to[v] = std::max(to[v], static_cast<To>(number));
        }
      });
    });
  }
  return labels;
}

}  // namespace

bool is_segment_name(const std::filesystem::path& path) {
  return lower_ascii(path.filename().string()).ends_with(".seg.nrrd");
}

std::vector<SegmentName> segments_of(const NrrdHeader& header) {
  std::vector<SegmentName> names;
  for (const DescribedSegment& segment : described_segments(header)) names.push_back(segment.name);
  return names;
}

VolumeSource open_layers(const VolumeInfo& info, const StoredVoxels& voxels, const NrrdHeader& header,
                         const std::filesystem::path& path) {
  Layers layers;
  layers.segments = described_segments(header);
  VolumeInfo stored = info;
  const std::int64_t count = std::int64_t{info.frames} * info.components;
  if (voxels.interleaved == 0 || count > kMaxSegments)
    header.fail("its segments overlap, and its " + std::to_string(count) + " layers are interleaved within slices",
                "export them as one label map");
  stored.frames = static_cast<int>(count), stored.components = 1, stored.segments.clear();
  std::set<int> values;
  bool renumbered = false;
  for (const DescribedSegment& segment : layers.segments) {
    if (segment.layer < 0 || segment.layer >= count)
      header.fail("its segment '" + one_line(segment.name.name, 60) + "' is in layer " + std::to_string(segment.layer) +
                  ", but its layers are 0 to " + std::to_string(count - 1));
    const bool distinct = values.insert(segment.value).second;
    renumbered = renumbered || !distinct || segment.value < 1 || segment.value > kMaxSegments;
  }
  VolumeSource source;
  for (const DescribedSegment& segment : layers.segments) {
    if (layers.readers.contains(segment.layer)) continue;
    VolumeSource layer = open_stored(stored, voxels, path, static_cast<int>(segment.layer) + 1);
    layers.readers.emplace(segment.layer, std::move(layer.read));
    source.info = std::move(layer.info);
  }
  source.extra_bytes = source.info.geometry.voxel_count() * static_cast<std::size_t>(bytes_per_voxel(source.info.type));
  source.info.frames = 1, source.info.frame = 0;
  std::erase_if(source.info.warnings, [](const std::string& warning) { return warning.starts_with("4D: "); });
  if (renumbered)
    source.info.warnings.push_back("label values of its layers are not distinct: the segments have the numbers 1 to " +
                                   std::to_string(layers.segments.size()) + " in the order of the file");
  int largest = 0;
  for (std::size_t n = 0; n < layers.segments.size(); ++n) {
    SegmentName& name = layers.segments[n].name;
    if (renumbered) name.value = static_cast<int>(n) + 1;
    largest = std::max(largest, name.value);
    source.info.segments.push_back(name);
  }
  source.info.type = largest > 255 ? VoxelType::UInt16 : VoxelType::UInt8;
  layers.info = source.info;
  const auto shared = std::make_shared<const Layers>(std::move(layers));
  const auto warnings = std::make_shared<std::vector<std::string>>();
  source.voxel_warnings = warnings;
  source.read = [shared, warnings] {
    LayerFaults faults;
    Volume labels = read_layers(*shared, std::nullopt, faults);
    warnings->clear();
    if (faults.shared > 0)
      warnings->push_back(
          counted(static_cast<std::int64_t>(faults.shared),
                  "voxel belongs to several segments and is assigned to the one with the highest number",
                  "voxels belong to several segments and are assigned to the one with the highest number"));
    if (faults.unnamed > 0)
      warnings->push_back(counted(static_cast<std::int64_t>(faults.unnamed),
                                  "voxel has a value that no segment has and is ignored",
                                  "voxels have values that no segment has and are ignored"));
    return labels;
  };
  source.read_segment = [shared](int segment) {
    LayerFaults faults;
    return read_layers(*shared, segment, faults);
  };
  return source;
}

std::string segment_fields(const Volume& labels, const std::vector<SegmentName>& names) {
  std::map<int, Extent> extents = extents_of(labels);
  std::vector<SegmentName> segments = names;
  for (const auto& entry : extents) {
    const int value = entry.first;
    const bool named = std::any_of(names.begin(), names.end(), [&](const SegmentName& n) { return n.value == value; });
    if (!named) segments.push_back({.value = value, .name = "label " + std::to_string(value)});
  }
  std::string text;
  const auto add = [&](const std::string& key, const std::string& value) {
    text.append(key).append(":=").append(value).append("\n");
  };
  for (std::size_t number = 0; number < segments.size(); ++number) {
    const SegmentName& segment = segments[number];
    const std::string prefix = prefix_of(number), id = "Segment_" + std::to_string(segment.value);
    const Colour& c = segment.colour;
    std::string colour;
    for (const std::uint8_t part : {c.red, c.green, c.blue})
      colour.append(colour.empty() ? "" : " ").append(digits_of(std::round(part / 255.0 * 1e6) / 1e6));
    std::string box;
    const Extent extent = extents.contains(segment.value) ? extents[segment.value] : Extent{0, -1, 0, -1, 0, -1};
    for (const int side : extent) box.append(box.empty() ? "" : " ").append(std::to_string(side));
    add(prefix + "Color", colour);
    add(prefix + "ColorAutoGenerated", "0");
    add(prefix + "Extent", box);
    add(prefix + "ID", id);
    add(prefix + "LabelValue", std::to_string(segment.value));
    add(prefix + "Layer", "0");
    add(prefix + "Name", segment.name.empty() ? id : one_line(segment.name, 200));
    add(prefix + "NameAutoGenerated", "0");
    add(prefix + "Tags", "Segmentation.Status:inprogress|" + terminology_entry(segment.code));
  }
  add("Segmentation_ContainedRepresentationNames", "Binary labelmap|");
  add("Segmentation_ConversionParameters", "");
  add("Segmentation_MasterRepresentation", "Binary labelmap");
  add("Segmentation_ReferenceImageExtentOffset", "0 0 0");
  return text;
}

}  // namespace simplexseg
