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
constexpr const char* kLabelMapSegmentation = "1.2.840.10008.5.1.4.1.1.66.7";
constexpr DicomTag kPixelData{0x7fe0, 0x0010};
/// Code of the segment that describes pixels outside all objects (DICOM PS3.16, CID 7150).
const CodedConcept kBackground{"DCM", "125040", "Background"};

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

std::vector<Frame> frames_of_segments(std::map<int, std::vector<bool>> slices) {
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

/// Returns a frame of all labels for each slice.
std::vector<Frame> frames_of_slices(std::size_t slices) {
  std::vector<Frame> frames;
  for (std::size_t k = 0; k < slices; ++k) frames.push_back({0, 0, k});
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

/// Adds the label values as pixels of 8 or 16 bits.
void add_label_pixels(DicomItem& data, const Volume& labels, int bits) {
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    const auto& voxels = labels.voxels<T>();
    const auto write = [&]<class Pixel>(std::type_identity<Pixel>) {
      std::vector<Pixel> pixels(voxels.size() + (sizeof(Pixel) == 1 ? voxels.size() % 2 : 0));
      std::transform(voxels.begin(), voxels.end(), pixels.begin(), [](T voxel) { return static_cast<Pixel>(voxel); });
      if constexpr (sizeof(Pixel) == 1)
        data.bytes(kPixelData, pixels);
      else
        data.words(kPixelData, pixels);
    };
    if (bits == 8)
      write(std::type_identity<std::uint8_t>());
    else
      write(std::type_identity<std::uint16_t>());
  });
}

/// `label`: name of the segment as DICOM text.
DicomItem segment_item(const WrittenSegment& segment, const SegmentName& name, const std::string& label,
                       const DicomSource& source) {
  DicomItem item;
  const std::uint16_t numbers[] = {static_cast<std::uint16_t>(segment.number)};
  item.shorts({0x0062, 0x0004}, numbers).text({0x0062, 0x0005}, label);
  item.text({0x0062, 0x0008}, "SEMIAUTOMATIC").text({0x0062, 0x0009}, "SimplexSeg 2-simplex mesh");
  item.text({0x0062, 0x0020}, segment.tracking_id).text({0x0062, 0x0021}, segment.tracking_uid);
  item.shorts({0x0062, 0x000d}, lab_of_colour(name.colour));
  add_segment_code(item, {0x0062, 0x000f}, name.code, source);
  return item;
}

/// Returns segment 0 of a label map: the value 0 occurs in the pixels, so it must be described.
DicomItem background_item(const DicomSource& source) {
  DicomItem item;
  const std::uint16_t numbers[] = {0};
  item.shorts({0x0062, 0x0004}, numbers).text({0x0062, 0x0005}, kBackground.meaning);
  item.text({0x0062, 0x0008}, "SEMIAUTOMATIC").text({0x0062, 0x0009}, "SimplexSeg 2-simplex mesh");
  add_segment_code(item, {0x0062, 0x000f}, {kBackground, kBackground, {}}, source);
  return item;
}

DicomItem frame_item(const Frame& frame, const DicomSource& source, SegmentEncoding encoding) {
  DicomItem content, position, reference = source.reference(frame.slice), derivation, segment, item;
  std::vector<std::uint32_t> index{static_cast<std::uint32_t>(frame.slice + 1)};
  if (encoding == SegmentEncoding::Binary) index.insert(index.begin(), frame.segment);
  content.longs({0x0020, 0x9157}, index);
  position.numbers({0x0020, 0x0032}, std::span(source.slices[frame.slice].position_mm.data(), 3));
  reference.code({0x0040, 0xa170}, "121322", "DCM", "Source image for image processing operation");
  reference.text({0x0028, 0x135a}, "YES");
  derivation.code({0x0008, 0x9215}, "113076", "DCM", "Segmentation");
  derivation.item({0x0008, 0x2112}, reference);
  const std::uint16_t number[] = {static_cast<std::uint16_t>(frame.segment)};
  segment.shorts({0x0062, 0x000b}, number);
  item.item({0x0020, 0x9111}, content).item({0x0020, 0x9113}, position).item({0x0008, 0x9124}, derivation);
  if (encoding == SegmentEncoding::Binary) item.item({0x0062, 0x000a}, segment);
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

/// Adds the dimensions that index the frames: segment, unless a frame has all of them, then position.
void describe_dimensions(DicomItem& data, SegmentEncoding encoding) {
  const std::string uid = new_dicom_uid();
  DicomItem organization;
  organization.text({0x0020, 0x9164}, uid);
  data.item({0x0020, 0x9221}, organization);
  std::vector<DicomItem> dimensions;
  const auto add = [&](DicomTag element, DicomTag group, const char* label) {
    DicomItem& dimension = dimensions.emplace_back();
    dimension.text({0x0020, 0x9164}, uid).pointer({0x0020, 0x9165}, element).pointer({0x0020, 0x9167}, group);
    dimension.text({0x0020, 0x9421}, label);
  };
  if (encoding == SegmentEncoding::Binary) add({0x0062, 0x000b}, {0x0062, 0x000a}, "Segment");
  add({0x0020, 0x0032}, {0x0020, 0x9113}, "Position");
  data.items({0x0020, 0x9222}, dimensions);
}

/// `bits`: of a pixel; 1 for a binary segmentation.
void describe_pixels(DicomItem& data, const DicomSource& source, std::size_t frames, int bits) {
  const VolumeGeometry& geometry = source.geometry;
  const auto number = [&](DicomTag tag, int value) {
    const std::uint16_t values[] = {static_cast<std::uint16_t>(value)};
    data.shorts(tag, values);
  };
  data.text({0x0008, 0x0008}, "DERIVED\\PRIMARY").text({0x0028, 0x0004}, "MONOCHROME2");
  number({0x0028, 0x0002}, 1), number({0x0028, 0x0010}, geometry.size[1]), number({0x0028, 0x0011}, geometry.size[0]);
  number({0x0028, 0x0100}, bits), number({0x0028, 0x0101}, bits), number({0x0028, 0x0102}, bits - 1);
  number({0x0028, 0x0103}, 0);
  if (bits > 1) number({0x0028, 0x0120}, 0);  // Pixel Padding Value: the background
  data.text({0x0028, 0x0008}, std::to_string(frames));
  const bool lossy = !source.lossy_ratio.empty() && !source.lossy_method.empty();
  data.text({0x0028, 0x2110}, lossy ? "01" : "00");
  if (lossy) data.text({0x0028, 0x2112}, source.lossy_ratio).text({0x0028, 0x2114}, source.lossy_method);
  data.text({0x0062, 0x0001}, bits > 1 ? "LABELMAP" : "BINARY")
      .text({0x0062, 0x0013}, "NO")
      .text({0x0070, 0x0080}, "SEGMENTATION");
  data.text({0x0070, 0x0081}, "").text({0x0070, 0x0084}, "").text({0x0008, 0x103e}, "Segmentation by SimplexSeg");
}

SegmentName name_of(int value, const std::vector<SegmentName>& names) {
  const auto named = std::find_if(names.begin(), names.end(), [&](const SegmentName& n) { return n.value == value; });
  return named != names.end() ? *named : SegmentName{.value = value, .name = "label " + std::to_string(value)};
}

}  // namespace

WrittenSegmentation write_dicom_segmentation(const std::filesystem::path& path, const Volume& labels,
                                             const std::vector<SegmentName>& names, DicomSource source,
                                             SegmentEncoding encoding) {
  const std::string what = "cannot write " + quoted(path);
  const VolumeGeometry& geometry = labels.geometry();
  if (!geometry.same_grid(source.geometry))
    throw Error(what, "the labels and the DICOM images have different grids",
                "create the labels on the grid of the images");
  const std::map<int, std::vector<bool>> slices = slices_of(labels, names);
  if (slices.empty()) throw Error(what, "no voxel is labelled", "create a segmentation first");
  const int first = slices.begin()->first, last = slices.rbegin()->first;
  if (first < 1 || last > 65535)
    throw Error(what, "a label has the value " + std::to_string(first < 1 ? first : last), "use values of 1 to 65535");
  const bool is_binary = encoding == SegmentEncoding::Binary;
  const int bits = is_binary ? 1 : last > 255 ? 16 : 8;
  const std::vector<Frame> frames = is_binary ? frames_of_segments(slices) : frames_of_slices(source.slices.size());
  const double bytes = double(frames.size()) * geometry.size[0] * geometry.size[1] * bits / 8;
  if (slices.size() > 65535 || bytes > double(std::numeric_limits<std::uint32_t>::max() - 2))
    throw Error(what, "it would take " + format_bytes(bytes) + ", more than DICOM allows", "use .seg.nrrd");

  DicomItem data = std::move(source.context);
  const DicomDateTime now = dicom_now();
  WrittenSegmentation written{is_binary ? kSegmentation : kLabelMapSegmentation, {}, {}, {}, {}};
  add_common_attributes(data, written.sop_class, "SEG", now);
  written.sop_instance = new_dicom_uid(), written.series = new_dicom_uid();
  data.text({0x0008, 0x0018}, written.sop_instance).text({0x0020, 0x000e}, written.series);
  data.text({0x0008, 0x0023}, now.date).text({0x0008, 0x0033}, now.time);
  describe_pixels(data, source, frames.size(), bits);
  describe_dimensions(data, encoding);
  std::vector<DicomItem> segments, places;
  std::vector<std::string> texts;
  texts.reserve(slices.size());
  for (const auto& [value, in] : slices) texts.push_back(name_of(value, names).name);
  texts = dicom_names(texts, source);
  if (!is_binary) segments.push_back(background_item(source));
  for (const auto& [value, in] : slices) {
    const std::size_t n = written.segments.size();
    const auto number = static_cast<std::uint32_t>(is_binary ? static_cast<int>(n) + 1 : value);
    written.segments.push_back({value, number, texts[n], new_dicom_uid()});
    segments.push_back(segment_item(written.segments.back(), name_of(value, names), texts[n], source));
    if (static_cast<int>(number) != value)
      written.note += (written.note.empty() ? "DICOM numbers segments from 1: label " : ", label ") +
                      std::to_string(value) + " is segment " + std::to_string(number);
  }
  data.items({0x0062, 0x0002}, segments);
  data.item({0x5200, 0x9229}, shared_item(geometry));
  places.reserve(frames.size());
  for (const Frame& frame : frames) places.push_back(frame_item(frame, source, encoding));
  data.items({0x5200, 0x9230}, places);
  DicomItem series;
  series.text({0x0020, 0x000e}, source.series).items({0x0008, 0x114a}, source.references());
  data.item({0x0008, 0x1115}, series);
  if (is_binary)
    data.bytes(kPixelData, bits_of(labels, frames));
  else
    add_label_pixels(data, labels, bits);

  AtomicFile file(path);
  write_dicom(file, data, DicomCoding::Explicit);
  file.commit();
  return written;
}

}  // namespace simplexseg
