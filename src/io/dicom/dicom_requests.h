// SPDX-License-Identifier: Apache-2.0
// Requests to the worker process that reads DICOM files with GDCM, and the functions that serve them. Functions of the
// namespace in_reader run in the worker process only, because GDCM can abort, crash and exhaust memory on damaged
// files.
#pragma once
#include <concepts>
#include <filesystem>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_values.h"
#include "io/dicom/rtstruct_read.h"
#include "io/platform/worker_request.h"
#include "io/source/dicom_slice.h"

namespace simplexseg {

class ResponseWriter;

// ---- packed structures; a new field that is missing here does not compile ----

template <class T, class Structure>
concept Is = std::same_as<std::remove_const_t<T>, Structure>;

template <Is<Colour> T>
auto fields_of(T& colour) {
  auto& [red, green, blue] = colour;
  return std::tie(red, green, blue);
}
template <Is<CodedConcept> T>
auto fields_of(T& one) {
  auto& [scheme, value, meaning] = one;
  return std::tie(scheme, value, meaning);
}
template <Is<SegmentCode> T>
auto fields_of(T& code) {
  auto& [category, type, modifier] = code;
  return std::tie(category, type, modifier);
}
template <Is<SegmentName> T>
auto fields_of(T& segment) {
  auto& [value, name, colour, code] = segment;
  return std::tie(value, name, colour, code);
}
template <Is<DicomTag> T>
auto fields_of(T& tag) {
  auto& [group, element] = tag;
  return std::tie(group, element);
}
template <Is<DicomPixels> T>
auto fields_of(T& pixels) {
  auto& [rows, columns, frames, samples, bits, stored_bits, high_bit, is_signed, plain, big_endian, in_words, start] =
      pixels;
  return std::tie(rows, columns, frames, samples, bits, stored_bits, high_bit, is_signed, plain, big_endian, in_words,
                  start);
}
template <Is<DicomSlice> T>
auto fields_of(T& slice) {
  auto& [file, frame, sop_class, sop_instance, series, description, modality, frame_of_reference, pixels, position,
         axes, spacing_mm, slice_distance_mm, stacked_backwards, thickness_mm, instance_number, slope, intercept,
         modality_lut, lut_begin, traits, segmentation, segment, segments, background, fraction_max, photometric,
         assumed, ignored, unreadable, remedy] = slice;
  return std::tie(file, frame, sop_class, sop_instance, series, description, modality, frame_of_reference, pixels,
                  position, axes, spacing_mm, slice_distance_mm, stacked_backwards, thickness_mm, instance_number,
                  slope, intercept, modality_lut, lut_begin, traits, segmentation, segment, segments, background,
                  fraction_max, photometric, assumed, ignored, unreadable, remedy);
}
template <Is<DicomFileScan> T>
auto fields_of(T& scan) {
  auto& [slices, failure] = scan;
  return std::tie(slices, failure);
}
template <Is<StructureRegion> T>
auto fields_of(T& region) {
  auto& [name, contours, other_contours, frame_of_reference, slab_mm, warnings] = region;
  return std::tie(name, contours, other_contours, frame_of_reference, slab_mm, warnings);
}

// ---- requests ----

/// Compressed file to be decoded.
using CompressedFile = std::pair<std::filesystem::path, DicomPixels>;

inline constexpr RequestType<std::vector<DicomFileScan>, std::vector<std::filesystem::path>> kDicomHeaders{
    "dicom headers"};
inline constexpr RequestType<std::string> kDicomClassName{"dicom class name"};
inline constexpr RequestType<bool> kDicomIsReadable{"dicom is readable"};
inline constexpr RequestType<std::vector<std::string>, std::vector<DicomTag>> kDicomTexts{"dicom texts"};
inline constexpr RequestType<std::vector<std::string>> kDicomdirNames{"dicomdir names"};
inline constexpr RequestType<std::vector<StructureRegion>> kStructureRegions{"structure regions"};
inline constexpr RequestType<void, std::vector<CompressedFile>> kDicomPixels{"dicom pixels"};

/// Tag that stands for the transfer syntax of the data set in a request of texts.
inline constexpr DicomTag kTransferSyntax{0x0002, 0x0010};

/// Reads texts of the data set up to the pixels. Returns one text for each tag, without padding and in the character
/// set of the file; empty when the element is missing or longer than any text of the standard. An element
/// that the data set does not have is read from the first item of its Radiopharmaceutical Information Sequence
/// (0054,0016). Throws like request_result(). The caller has checked the file by damage_of_header().
std::vector<std::string> read_dicom_values(const std::filesystem::path& file, const std::vector<DicomTag>& tags);

namespace in_reader {

std::vector<DicomFileScan> scan_dicom_files(const std::filesystem::path& first,
                                            const std::vector<std::filesystem::path>& files);
std::string sop_class_name(const std::filesystem::path& path);
bool is_readable_dicom(const std::filesystem::path& path);
std::vector<std::string> read_dicom_values(const std::filesystem::path& path, const std::vector<DicomTag>& tags);
std::vector<std::string> names_in_dicomdir(const std::filesystem::path& path);
std::vector<StructureRegion> read_structure_regions(const std::filesystem::path& path);
/// Sends the decoded frames of each file.
void decode_pixels(ResponseWriter& response, const std::filesystem::path& first,
                   const std::vector<CompressedFile>& files);

}  // namespace in_reader
}  // namespace simplexseg
