// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_write/dicom_seg_write.h"

#include <algorithm>
#include <limits>
#include <map>

#include "io/dicom/dicom_colour.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr const char* kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4";

/// Returns for each label of the volume and of `names`, by slice index, whether the slice contains voxels of the label.
std::map<int, std::vector<bool>> slices_of(const Volume& labels, const std::vector<SegmentName>& names) {
  const auto [ni, nj, nk] = labels.geometry().size;
  const std::size_t plane = static_cast<std::size_t>(ni) * nj, slices = static_cast<std::size_t>(nk);
  std::map<int, std::vector<bool>> found;
  for (const SegmentName& name : names) found[name.value].resize(slices);
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const T* voxel = labels.voxels<T>().data();
    for (std::size_t k = 0; k < slices; ++k) {
      T last = 0;
      for (std::size_t v = 0; v < plane; ++v, ++voxel) {
        if (*voxel == last || *voxel == T(0)) continue;
        last = *voxel;
        std::vector<bool>& in = found[static_cast<int>(last)];
        in.resize(slices);
        in[k] = true;
      }
    }
  });
  return found;
}

struct Frame {
  int label;
  std::uint32_t segment;  ///< from 1
  std::size_t slice;
};

std::vector<Frame> frames_of(std::map<int, std::vector<bool>> slices) {
  std::vector<bool>& first = slices.begin()->second;
  for (std::size_t k = 0; k < first.size(); ++k)
    first[k] = first[k] || std::none_of(slices.begin(), slices.end(), [k](const auto& one) { return one.second[k]; });
  std::vector<Frame> frames;
  std::uint32_t segment = 0;
  for (const auto& [label, in] : slices) {
    ++segment;
    for (std::size_t k = 0; k < in.size(); ++k)
      if (in[k]) frames.push_back({label, segment, k});
  }
  return frames;
}

/// Packs the voxels to one bit each, lowest bit first, without gaps between frames (PS3.5 8.1.1).
std::vector<std::uint8_t> bits_of(const Volume& labels, const std::vector<Frame>& frames) {
  const std::size_t plane = static_cast<std::size_t>(labels.geometry().size[0]) * labels.geometry().size[1];
  const std::size_t bytes = (frames.size() * plane + 7) / 8;
  std::vector<std::uint8_t> bits(bytes + bytes % 2);
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    std::size_t at = 0;
    for (const Frame& frame : frames) {
      const T* voxel = labels.voxels<T>().data() + frame.slice * plane;
      const T label = static_cast<T>(frame.label);
      for (std::size_t v = 0; v < plane; ++v, ++at)
        if (voxel[v] == label) bits[at / 8] |= static_cast<std::uint8_t>(1u << (at % 8));
    }
  });
  return bits;
}

/// `label`: name of the segment as DICOM text.
DicomItem segment_item(std::uint32_t number, const SegmentName& segment, const std::string& label,
                       const DicomSource& source) {
  DicomItem item;
  const std::uint16_t numbers[] = {static_cast<std::uint16_t>(number)};
  item.shorts({0x0062, 0x0004}, numbers).text({0x0062, 0x0005}, label);
  item.text({0x0062, 0x0008}, "SEMIAUTOMATIC").text({0x0062, 0x0009}, "SimplexSeg 2-simplex mesh");
  item.shorts({0x0062, 0x000d}, lab_of_colour(segment.colour));
  add_segment_code(item, {0x0062, 0x000f}, segment.code, source);
  return item;
}

DicomItem frame_item(const Frame& frame, const DicomSource& source) {
  DicomItem content, position, reference = source.reference(frame.slice), derivation, segment, item;
  const std::uint32_t index[] = {frame.segment, static_cast<std::uint32_t>(frame.slice + 1)};
  content.longs({0x0020, 0x9157}, index);
  position.numbers({0x0020, 0x0032}, std::span(source.slices[frame.slice].position_mm.data(), 3));
  reference.code({0x0040, 0xa170}, "121322", "DCM", "Source image for image processing operation");
  reference.text({0x0028, 0x135a}, "YES");
  derivation.code({0x0008, 0x9215}, "113076", "DCM", "Segmentation");
  derivation.item({0x0008, 0x2112}, reference);
  const std::uint16_t number[] = {static_cast<std::uint16_t>(frame.segment)};
  segment.shorts({0x0062, 0x000b}, number);
  item.item({0x0020, 0x9111}, content).item({0x0020, 0x9113}, position);
  item.item({0x0008, 0x9124}, derivation).item({0x0062, 0x000a}, segment);
  return item;
}

/// Returns the functional groups shared by all frames: orientation and voxel size.
DicomItem shared_item(const VolumeGeometry& geometry) {
  DicomItem orientation, measures, item;
  orientation.numbers({0x0020, 0x0037}, std::span(geometry.direction.data(), 6));
  const Eigen::Vector3d normal = geometry.direction.col(0).cross(geometry.direction.col(1));
  const double between[] = {std::abs(normal.dot(geometry.direction.col(2))) * geometry.spacing_mm[2]};
  const double rows_and_columns[] = {geometry.spacing_mm[1], geometry.spacing_mm[0]};
  measures.numbers({0x0018, 0x0050}, between).numbers({0x0018, 0x0088}, between);
  measures.numbers({0x0028, 0x0030}, rows_and_columns);
  item.item({0x0020, 0x9116}, orientation).item({0x0028, 0x9110}, measures);
  return item;
}

/// Adds the dimensions that index the frames: segment, then position.
void describe_dimensions(DicomItem& data) {
  const std::string uid = new_dicom_uid();
  DicomItem organization;
  organization.text({0x0020, 0x9164}, uid);
  data.item({0x0020, 0x9221}, organization);
  std::vector<DicomItem> dimensions(2);
  for (DicomItem& dimension : dimensions) dimension.text({0x0020, 0x9164}, uid);
  dimensions[0].pointer({0x0020, 0x9165}, {0x0062, 0x000b}).pointer({0x0020, 0x9167}, {0x0062, 0x000a});
  dimensions[0].text({0x0020, 0x9421}, "Segment");
  dimensions[1].pointer({0x0020, 0x9165}, {0x0020, 0x0032}).pointer({0x0020, 0x9167}, {0x0020, 0x9113});
  dimensions[1].text({0x0020, 0x9421}, "Position");
  data.items({0x0020, 0x9222}, dimensions);
}

void describe_pixels(DicomItem& data, const DicomSource& source, std::size_t frames) {
  const VolumeGeometry& geometry = source.geometry;
  const auto number = [&](DicomTag tag, int value) {
    const std::uint16_t values[] = {static_cast<std::uint16_t>(value)};
    data.shorts(tag, values);
  };
  data.text({0x0008, 0x0008}, "DERIVED\\PRIMARY").text({0x0028, 0x0004}, "MONOCHROME2");
  number({0x0028, 0x0002}, 1), number({0x0028, 0x0010}, geometry.size[1]), number({0x0028, 0x0011}, geometry.size[0]);
  number({0x0028, 0x0100}, 1), number({0x0028, 0x0101}, 1), number({0x0028, 0x0102}, 0), number({0x0028, 0x0103}, 0);
  data.text({0x0028, 0x0008}, std::to_string(frames));
  const bool lossy = !source.lossy_ratio.empty() && !source.lossy_method.empty();
  data.text({0x0028, 0x2110}, lossy ? "01" : "00");
  if (lossy) data.text({0x0028, 0x2112}, source.lossy_ratio).text({0x0028, 0x2114}, source.lossy_method);
  data.text({0x0062, 0x0001}, "BINARY").text({0x0062, 0x0013}, "NO").text({0x0070, 0x0080}, "SEGMENTATION");
  data.text({0x0070, 0x0081}, "").text({0x0070, 0x0084}, "").text({0x0008, 0x103e}, "Segmentation by SimplexSeg");
}

SegmentName name_of(int value, const std::vector<SegmentName>& names) {
  const auto named = std::find_if(names.begin(), names.end(), [&](const SegmentName& n) { return n.value == value; });
  return named != names.end() ? *named : SegmentName{.value = value, .name = "label " + std::to_string(value)};
}

}  // namespace

std::string write_dicom_segmentation(const std::filesystem::path& path, const Volume& labels,
                                     const std::vector<SegmentName>& names, DicomSource source) {
  const std::string what = "cannot write " + quoted(path);
  const VolumeGeometry& geometry = labels.geometry();
  if (!geometry.same_grid(source.geometry))
    throw Error(what, "the labels and the DICOM images have different grids",
                "create the labels on the grid of the images");
  const std::map<int, std::vector<bool>> slices = slices_of(labels, names);
  if (slices.empty()) throw Error(what, "no voxel is labelled", "create a segmentation first");
  if (slices.begin()->first < 1)
    throw Error(what, "a label has the value " + std::to_string(slices.begin()->first), "use values above 0");
  const std::vector<Frame> frames = frames_of(slices);
  const double bytes = double(frames.size()) * geometry.size[0] * geometry.size[1] / 8;
  if (slices.size() > 65535 || bytes > double(std::numeric_limits<std::uint32_t>::max() - 2))
    throw Error(what, "it would take " + format_bytes(bytes) + ", more than DICOM allows", "use .seg.nrrd");

  DicomItem data = std::move(source.context);
  const DicomDateTime now = dicom_now();
  add_common_attributes(data, kSegmentation, "SEG", now);
  data.text({0x0008, 0x0023}, now.date).text({0x0008, 0x0033}, now.time);
  describe_pixels(data, source, frames.size());
  describe_dimensions(data);
  std::vector<DicomItem> segments, places;
  std::string renumbered;
  std::vector<std::string> texts;
  texts.reserve(slices.size());
  for (const auto& [value, in] : slices) texts.push_back(name_of(value, names).name);
  texts = dicom_names(texts, source);
  for (const auto& [value, in] : slices) {
    const std::size_t n = segments.size();
    segments.push_back(segment_item(static_cast<std::uint32_t>(n + 1), name_of(value, names), texts[n], source));
    if (static_cast<int>(segments.size()) != value)
      renumbered += (renumbered.empty() ? "label " : ", label ") + std::to_string(value) + " is segment " +
                    std::to_string(segments.size());
  }
  data.items({0x0062, 0x0002}, segments);
  data.item({0x5200, 0x9229}, shared_item(geometry));
  places.reserve(frames.size());
  for (const Frame& frame : frames) places.push_back(frame_item(frame, source));
  data.items({0x5200, 0x9230}, places);
  DicomItem series;
  series.text({0x0020, 0x000e}, source.series).items({0x0008, 0x114a}, source.references());
  data.item({0x0008, 0x1115}, series);
  data.bytes({0x7fe0, 0x0010}, bits_of(labels, frames));

  AtomicFile file(path);
  write_dicom(file, data, DicomCoding::Explicit);
  file.commit();
  return renumbered.empty() ? "" : "DICOM numbers segments from 1: " + renumbered;
}

}  // namespace simplexseg
