// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_scan.h"

#include <gdcmReader.h>
#include <gdcmUIDs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <utility>

#include "core/number_text.h"
#include "core/system_error.h"
#include "io/dicom/dicom_codes.h"
#include "io/dicom/dicom_colour.h"
#include "io/dicom/dicom_frames.h"
#include "io/dicom/dicom_requests.h"
#include "io/dicom/dicom_texts.h"
#include "io/dicom/dicom_validation.h"
#include "io/dicom/dicom_values.h"
#include "io/platform/files.h"
#include "io/platform/worker_channel.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// Returns a description of missing or damaged pixel data, or an empty text. GDCM itself would leave missing pixels
/// undefined without an error. Colour images can be subsampled to two thirds of their size.
std::string damage_of_pixels(const fs::path& path, const gdcm::TransferSyntax& syntax, const DicomPixels& pixels) {
  // Offsets of pixels in a deflated file are unknown.
  if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) return {};
  if (syntax.IsEncapsulated()) return damage_of_fragments(path, pixels);
  const double required_bytes = double(pixels.rows) * pixels.columns * pixels.samples * pixels.frames * pixels.bits / 8;
  if (double(pixels.start) + (pixels.samples > 1 ? 0.66 : 1) * required_bytes <= double(fs::file_size(path))) return {};
  return "truncated: the file ends before its pixel data";
}

std::string uid_of(const gdcm::DataSet& data, DicomTag tag) {
  const std::string text = text_of(data, tag);
  return text.substr(0, text.find_first_not_of(".0123456789"));
}

void read_segmentation(const gdcm::DataSet& data, DicomSlice& slice) {
  const std::string sop_class = text_of(data, {0x0008, 0x0016});
  if (!sop_class.starts_with("1.2.840.10008.5.1.4.1.1.66.4") && !sop_class.starts_with("1.2.840.10008.5.1.4.1.1.66.7"))
    return;
  slice.segmentation = text_of(data, {0x0062, 0x0001});
  if (slice.segmentation.empty()) slice.segmentation = "BINARY";
  slice.fraction_max = short_of(data, {0x0062, 0x000e}, 255);
  const bool is_label_map = slice.segmentation == "LABELMAP";
  if (is_label_map) slice.background = short_of(data, {0x0028, 0x0120}, 0);  // Pixel Padding Value, PS3.3 C.8.20.2
  const std::string coding = text_of(data, {0x0008, 0x0005});
  std::vector<SegmentName> segments;
  each_item(data, {0x0062, 0x0002}, [&](const gdcm::DataSet& item) {
    SegmentName segment{.value = short_of(item, {0x0062, 0x0004}, 0),
                        .name = utf8_of(raw_text_of(item, {0x0062, 0x0005}), coding)};
    bool is_background = segment.value == slice.background;
    first_item(item, {0x0062, 0x000f}, [&](const gdcm::DataSet& type) {
      is_background = is_background || text_of(type, {0x0008, 0x0100}).starts_with("125040");  // DCM, Background
    });
    if (is_label_map && is_background) {
      slice.background = segment.value;
      return;
    }
    const std::vector<double> lab = numbers_of(item, {0x0062, 0x000d}, DicomKind::Short);
    if (lab.size() == 3)
      segment.colour = colour_of_lab(
          {static_cast<std::uint16_t>(lab[0]), static_cast<std::uint16_t>(lab[1]), static_cast<std::uint16_t>(lab[2])});
    segment.code = read_segment_code(item, {0x0062, 0x000f}, coding);
    segments.push_back(segment);
  });
  slice.segments = std::make_shared<const std::vector<SegmentName>>(std::move(segments));
}

/// Reads the table of the Modality LUT Sequence. Its entries have 8 or 16 bits; those of 8 bits can share words.
void read_modality_lut(const gdcm::DataSet& data, DicomSlice& slice) {
  constexpr DicomTag kDescriptor{0x0028, 0x3002}, kTable{0x0028, 0x3006};
  first_item(data, {0x0028, 0x3000}, [&](const gdcm::DataSet& item) {
    const std::vector<double> descriptor = numbers_of(item, kDescriptor, DicomKind::Short, 3);
    const std::vector<double> words = numbers_of(item, kTable, DicomKind::Short);
    if (descriptor.empty()) throw InvalidElement("its " + element_name(kDescriptor) + " is missing");
    const std::size_t entries = descriptor[0] == 0 ? 65536 : static_cast<std::size_t>(descriptor[0]);
    std::vector<std::uint16_t> table;
    for (const double word : words) {
      const auto value = static_cast<std::uint16_t>(word);
      if (words.size() >= entries) {
        table.push_back(value);
      } else {
        table.push_back(static_cast<std::uint16_t>(value & 0xff));
        table.push_back(static_cast<std::uint16_t>(value >> 8));
      }
    }
    if (table.size() < entries)
      throw InvalidElement("its " + element_name(kTable) + " has fewer entries than its " + element_name(kDescriptor) +
                           " states");
    table.resize(entries);
    const auto begin = static_cast<std::uint16_t>(descriptor[1]);
    slice.lut_begin = slice.pixels.is_signed ? static_cast<std::int16_t>(begin) : begin;
    slice.modality_lut = std::make_shared<const std::vector<std::uint16_t>>(std::move(table));
    slice.slope = 1, slice.intercept = 0;
  });
}

/// Whether the pixel data, whose value begins at `start`, has the value representation OW (explicit encodings).
bool is_stored_in_words(const fs::path& path, std::size_t start) {
  std::ifstream stream(path, std::ios::binary);
  std::array<char, 2> vr{};
  constexpr std::size_t kBytesFromVr = 8;  // value representation, two reserved bytes, length
  return start >= kBytesFromVr && stream.seekg(static_cast<std::streamoff>(start - kBytesFromVr)) &&
         stream.read(vr.data(), 2) && vr[0] == 'O' && vr[1] == 'W';
}

void reject_mosaic(const gdcm::DataSet& data, DicomSlice& slice) {
  if (slice.pixels.frames > 1 || text_of(data, {0x0008, 0x0008}).find("MOSAIC") == std::string::npos) return;
  slice.unreadable = "Siemens mosaics (all slices of a volume as tiles of one image) are not supported";
  slice.remedy = "convert it to NIfTI or export it as enhanced DICOM";
}

/// Throws std::runtime_error for transfer syntaxes that GDCM 3.0 cannot decode.
void require_supported_syntax(const gdcm::FileMetaInformation& header) {
  const std::string uid = uid_of(header, {0x0002, 0x0010});
  if (uid.starts_with("1.2.840.10008.1.2.4.10")) throw std::runtime_error("it is a video, which is not supported");
  if (!uid.empty() && gdcm::TransferSyntax::GetTSType(uid.c_str()) == gdcm::TransferSyntax::TS_END)
    throw std::runtime_error("its transfer syntax " + uid + " is not supported");
}

/// Returns the slices of an image whose header has been read up to the pixels; none when it is no image. `whole`
/// contains the identity of the file and receives the attributes that all frames share.
std::vector<DicomSlice> slices_of(gdcm::Reader& reader, const fs::path& path, DicomSlice& whole) {
  const gdcm::DataSet& data = reader.GetFile().GetDataSet();
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  DicomPixels& pixels = whole.pixels;
  pixels.rows = short_of(data, {0x0028, 0x0010}, 0);
  pixels.columns = short_of(data, {0x0028, 0x0011}, 0);
  pixels.samples = short_of(data, {0x0028, 0x0002}, 1);
  pixels.bits = short_of(data, {0x0028, 0x0100}, 0);
  pixels.stored_bits = short_of(data, {0x0028, 0x0101}, pixels.bits);
  pixels.high_bit = short_of(data, {0x0028, 0x0102}, pixels.stored_bits - 1);
  pixels.is_signed = short_of(data, {0x0028, 0x0103}, 0) == 1;
  pixels.plain = !syntax.IsEncapsulated() && syntax != gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  pixels.big_endian = syntax == gdcm::TransferSyntax::ExplicitVRBigEndian;
  whole.photometric = text_of(data, {0x0028, 0x0004});
  if (const auto n = integer_of(data, {0x0028, 0x0008})) pixels.frames = int(std::clamp(*n, 1.0, 1e8));
  pixels.start = reader.GetStreamCurrentPosition();
  if (pixels.rows < 1 || pixels.columns < 1 || pixels.bits < 1 || pixels.start == std::size_t(-1)) return {};
  pixels.in_words = pixels.big_endian && pixels.bits <= 8 && is_stored_in_words(path, pixels.start);
  read_image_plane(data, whole);
  read_rescaling(data, whole);
  read_modality_lut(data, whole);
  read_segmentation(data, whole);
  reject_mosaic(data, whole);
  if (whole.unreadable.empty()) whole.unreadable = damage_of_pixels(path, syntax, pixels);
  return whole.unreadable.empty() ? frames_of(data, whole) : std::vector{whole};
}

/// Returns true when the numbers that DicomFrames uses as sizes and indices are in their ranges. A damaged file can
/// have made the worker process send others.
bool is_plausible(const DicomSlice& slice) {
  constexpr int max_value = 65535, max_frames = 100000000;
  const DicomPixels& p = slice.pixels;
  const auto is_within = [](int value, int lowest, int highest) { return value >= lowest && value <= highest; };
  return is_within(p.rows, 1, max_value) && is_within(p.columns, 1, max_value) && is_within(p.bits, 1, max_value) &&
         is_within(p.samples, 0, max_value) && is_within(p.frames, 1, max_frames) &&
         is_within(slice.frame, 0, p.frames - 1) && (slice.segmentation.empty() || slice.segments) &&
         (!slice.modality_lut || !slice.modality_lut->empty());
}

std::vector<DicomSlice> slices_in(const fs::path& path) {
  const gdcm::Tag pixel_data(0x7fe0, 0x0010);
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  const bool is_dicom = reader.ReadUpToTag(pixel_data, {pixel_data});  // stops before the pixels
  require_supported_syntax(reader.GetFile().GetHeader());
  if (!is_dicom) return {};
  const gdcm::DataSet& data = reader.GetFile().GetDataSet();
  DicomSlice whole;
  whole.file = path;
  whole.sop_class = uid_of(data, {0x0008, 0x0016});
  whole.sop_instance = uid_of(data, {0x0008, 0x0018});
  whole.series = text_of(data, {0x0020, 0x000e});
  whole.description = text_of(data, {0x0008, 0x103e});
  whole.frame_of_reference = uid_of(data, {0x0020, 0x0052});
  whole.modality = text_of(data, {0x0008, 0x0060});
  whole.instance_number = parse_number(text_of(data, {0x0020, 0x0013}));
  try {
    return slices_of(reader, path, whole);
  } catch (const InvalidElement& error) {
    whole.position.reset();  // it could belong anywhere in the series
    whole.unreadable = error.what();
    whole.remedy = "correct this value or export it again";
    return {whole};
  }
}

/// Returns the reason why a file cannot be opened; empty when it can.
std::string open_failure(const fs::path& path) {
  errno = 0;
  const std::ifstream stream(path, std::ios::binary);
  if (stream) return {};
  return errno != 0 ? system_error_text(errno) : "it cannot be opened";
}

/// Returns true when the worker process should read the header. Otherwise the file is not DICOM, or it is damaged, and
/// `failure` receives the reason.
bool has_readable_header(const fs::path& path, std::string& failure) {
  try {
    failure = open_failure(path);
    if (!failure.empty() || !has_dicom_header(path)) return false;
    failure = damage_of_header(path);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception& exception) {
    failure = message_of(exception);
  }
  return failure.empty();
}

/// Batch of files whose headers the worker process reads while the program checks those of the next.
class HeaderBatch {
 public:
  HeaderBatch(const std::vector<fs::path>& files, std::vector<DicomFileScan>& scans) : files_(files), scans_(scans) {}

  /// Adds the file with this index. Returns true when the batch is full.
  bool add(std::size_t index) {
    constexpr std::size_t max_files = 64;
    constexpr std::uintmax_t max_bytes = 64 << 20;
    if (next_.empty()) prepare_reader();
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(files_[index], error);
    next_.push_back(index);
    next_bytes_ += error ? 0 : bytes;
    return next_.size() >= max_files || next_bytes_ >= max_bytes;
  }

  /// Receives the headers that are in request, and requests those of the files that were added since.
  void exchange() {
    receive();
    requested_ = std::exchange(next_, {});
    bytes_ = std::exchange(next_bytes_, 0);
    request(requested_.size());
  }

  /// Receives the headers that are in request. When a request for several files fails, each is requested alone, so that
  /// only a damaged file is omitted.
  void receive() {
    while (request_) {
      try {
        store(result_of(*request_, kDicomHeaders));
      } catch (const WorkerFailure& failure) {
        if (in_request_ == 1) scans_[requested_[received_++]] = {.slices = {}, .failure = failure.what()};
      }
      request(1);
    }
  }

 private:
  /// Requests the next `count` headers, or less if less are left.
  void request(std::size_t count) {
    request_.reset();
    in_request_ = std::min(count, requested_.size() - received_);
    if (in_request_ == 0) {
      requested_.clear();
      received_ = 0;
      return;
    }
    std::vector<fs::path> paths;
    paths.reserve(in_request_);
    for (std::size_t n = 0; n < in_request_; ++n) paths.push_back(fs::absolute(files_[requested_[received_ + n]]));
    WorkerLimits limits = limits_for_bytes(bytes_);
    limits.min_idle_timeout_s += static_cast<int>(in_request_);  // files can be on a slow disk
    const fs::path& first = files_[requested_[received_]];
    request_ = std::make_unique<WorkerRequest>(packed_request(kDicomHeaders, first, paths), first, limits);
  }

  void store(std::vector<DicomFileScan> found) {
    if (found.size() != in_request_) throw WorkerFailure(kReaderProgram.crash);
    for (const DicomFileScan& scan : found)
      if (!std::all_of(scan.slices.begin(), scan.slices.end(), is_plausible)) throw WorkerFailure(kReaderProgram.crash);
    for (DicomFileScan& scan : found) {
      const std::size_t index = requested_[received_++];
      for (DicomSlice& slice : scan.slices) slice.file = files_[index];
      scans_[index] = std::move(scan);
    }
  }

  const std::vector<fs::path>& files_;
  std::vector<DicomFileScan>& scans_;
  std::vector<std::size_t> next_, requested_;  ///< indices of files
  std::uintmax_t next_bytes_ = 0, bytes_ = 0;  ///< sizes of next_ and requested_
  std::size_t received_ = 0;                   ///< number of requested_ files that are done
  std::size_t in_request_ = 0;                 ///< number of files in request_
  std::unique_ptr<WorkerRequest> request_;
};

}  // namespace

std::vector<DicomFileScan> in_reader::scan_dicom_files(const fs::path&, const std::vector<fs::path>& files) {
  std::vector<DicomFileScan> scans(files.size());
  for (std::size_t n = 0; n < files.size(); ++n) {
    restart_processor_time();
    try {
      scans[n].slices = slices_in(files[n]);
    } catch (...) {
      scans[n].failure = reason_of_exception(kReaderProgram.crash);
    }
  }
  return scans;
}

std::vector<DicomFileScan> scan_dicom_files(const std::vector<fs::path>& files,
                                            const std::function<void(std::size_t)>& report) {
  std::vector<DicomFileScan> scans(files.size());
  HeaderBatch batch(files, scans);
  for (std::size_t index = 0; index < files.size(); ++index) {
    report(index);
    if (has_readable_header(files[index], scans[index].failure) && batch.add(index)) batch.exchange();
  }
  batch.exchange();
  batch.receive();
  return scans;
}

std::vector<DicomSlice> scan_dicom(const fs::path& path) {
  DicomFileScan scan = std::move(scan_dicom_files({path}, [](std::size_t) {}).front());
  if (!scan.failure.empty()) throw std::runtime_error(scan.failure);
  return std::move(scan.slices);
}

std::string in_reader::sop_class_name(const fs::path& path) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(gdcm::Tag(0x0008, 0x0060))) return {};
  std::string uid = uid_of(reader.GetFile().GetDataSet(), {0x0008, 0x0016});
  if (uid.empty()) uid = uid_of(reader.GetFile().GetHeader(), {0x0002, 0x0002});
  gdcm::UIDs known;
  return known.SetFromUID(uid.c_str()) && known.GetName() ? known.GetName() : "";
}

std::string sop_class_name(const fs::path& path) {
  if (!has_dicom_header(path) || !damage_of_header(path).empty()) return {};
  try {
    return request_result(kDicomClassName, path, {});
  } catch (const WorkerFailure&) {
    return {};
  }
}

std::string name_of(const DicomSlice& slice) {
  const std::string name = quoted(slice.file.filename());
  return slice.pixels.frames > 1 ? "frame " + std::to_string(slice.frame + 1) + " of " + name : name;
}

std::string list_of(const std::vector<std::string>& names, std::size_t max_names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < max_names; ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > max_names) text += " and " + std::to_string(names.size() - max_names) + " more";
  return text;
}

}  // namespace simplexseg
