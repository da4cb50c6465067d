// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_pixels.h"

#include <gdcmPixmapReader.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include "io/dicom/dicom_requests.h"
#include "io/platform/files.h"
#include "io/platform/worker_channel.h"

namespace simplexseg {
namespace {

VoxelType stored_type_of(const DicomPixels& p) {
  if (p.bits <= 8) return p.is_signed ? VoxelType::Int8 : VoxelType::UInt8;
  if (p.bits <= 16) return p.is_signed ? VoxelType::Int16 : VoxelType::UInt16;
  return p.is_signed ? VoxelType::Int32 : VoxelType::UInt32;
}

[[noreturn]] void fail(const DicomSlice& slice, const std::string& why) {
  throw Error("cannot read " + quoted(slice.file), why, "copy or export the file again");
}

std::size_t pixels_of_frame(const DicomPixels& p) {
  return static_cast<std::size_t>(p.rows) * static_cast<std::size_t>(p.columns);
}

std::size_t bytes_of_frame(const DicomPixels& p) { return pixels_of_frame(p) * bytes_per_voxel(stored_type_of(p)); }
std::size_t bytes_of_file(const DicomPixels& p) { return bytes_of_frame(p) * static_cast<std::size_t>(p.frames); }

/// Returns true when the pixels can be read directly from the file.
bool is_plain(const DicomPixels& p) { return p.plain && (p.bits == 1 || p.bits == 8 || p.bits == 16 || p.bits == 32); }

/// Decodes all frames of a file with GDCM. Throws std::runtime_error with the reason when that fails.
std::vector<char> decode_file(const std::filesystem::path& file, const DicomPixels& pixels) {
  gdcm::PixmapReader reader;
  reader.SetFileName(file.c_str());
  if (!reader.Read()) throw std::runtime_error("its header or its pixels are damaged");
  const gdcm::Pixmap& pixmap = reader.GetPixmap();
  if (pixmap.GetBufferLength() != bytes_of_file(pixels))
    throw std::runtime_error("its pixels do not match the size and type in its header");
  std::vector<char> bytes(bytes_of_file(pixels));
  if (!pixmap.GetBuffer(bytes.data())) throw std::runtime_error("its pixels are damaged");
  return bytes;
}

/// Returns the limits of the request. damage_of_fragments() has already bounded the decompressed size of each file.
WorkerLimits decoding_limits(const std::vector<CompressedFile>& files) {
  constexpr double min_bytes_per_second = 5e5;  // far below the speed of the slowest codec
  WorkerLimits limits;
  double max_memory = 0, compressed_bytes = 0;
  for (const auto& [file, pixels] : files) {
    const auto size = static_cast<double>(std::filesystem::file_size(file));
    max_memory = std::max(max_memory, 6 * static_cast<double>(bytes_of_file(pixels)) + 4 * size);
    compressed_bytes += size;
  }
  limits.memory_bytes += static_cast<std::size_t>(max_memory);
  limits.cpu_seconds += static_cast<int>(std::min(compressed_bytes / min_bytes_per_second, 1e6));
  return limits;
}

/// Expands a frame of 1-bit pixels to one byte each. `first` is the index of its first pixel in the file; the frame can
/// start at any bit of a byte.
void unpack_bits(const std::vector<char>& packed, std::size_t first, std::vector<std::byte>& pixels) {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::size_t at = first % 8 + i;
    pixels[i] = static_cast<std::byte>((static_cast<unsigned char>(packed[at / 8]) >> (at % 8)) & 1);
  }
}

template <class T>
void swap_bytes(std::vector<std::byte>& bytes) {
  for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T))
    std::reverse(bytes.data() + i, bytes.data() + i + sizeof(T));
}

/// Clears all bits other than the stored bits, since they can contain overlays, and extends the sign.
template <class T>
void mask_stored_bits(std::byte* bytes, std::size_t count, const DicomPixels& p) {
  constexpr int width = 8 * sizeof(T);
  if (p.stored_bits < 1 || p.stored_bits >= width || p.high_bit < p.stored_bits - 1 || p.high_bit >= width) return;
  using Wide = std::make_unsigned_t<T>;
  auto* values = reinterpret_cast<T*>(bytes);
  for (std::size_t i = 0; i < count; ++i) {
    const auto top = static_cast<T>(static_cast<Wide>(static_cast<Wide>(values[i]) << (width - 1 - p.high_bit)));
    values[i] = static_cast<T>(top >> (width - p.stored_bits));  // arithmetic where T is signed
  }
}

}  // namespace

VoxelType voxel_type_of(const DicomSlice& slice) {
  const DicomPixels& p = slice.pixels;
  if (slice.modality_lut) return VoxelType::UInt16;
  if (slice.slope == 1 && slice.intercept == 0) return stored_type_of(p);
  const VoxelType real = p.stored_bits > 24 ? VoxelType::Float64 : VoxelType::Float32;
  if (slice.slope != std::rint(slice.slope) || slice.intercept != std::rint(slice.intercept)) return real;
  const int bits = std::clamp(p.stored_bits, 1, 32);
  const double low = p.is_signed ? -std::ldexp(1.0, bits - 1) : 0, span = std::ldexp(1.0, bits) - 1;
  if (bits == 16 && slice.slope == 1 && std::abs(slice.intercept) <= 32768 && (p.is_signed || slice.intercept < 0))
    return VoxelType::Int16;
  const double a = slice.slope * low + slice.intercept, b = slice.slope * (low + span) + slice.intercept;
  const double lowest = std::min(a, b), highest = std::max(a, b);
  for (const VoxelType type :
       {VoxelType::UInt8, VoxelType::Int8, VoxelType::UInt16, VoxelType::Int16, VoxelType::UInt32, VoxelType::Int32}) {
    const bool fits = visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      return lowest >= double(std::numeric_limits<T>::lowest()) && highest <= double(std::numeric_limits<T>::max());
    });
    if (fits) return type;
  }
  return real;
}

void in_reader::decode_pixels(ResponseWriter& response, const std::filesystem::path&,
                              const std::vector<CompressedFile>& files) {
  for (const auto& [file, pixels] : files) {
    const std::vector<char> bytes = decode_file(file, pixels);
    response.data(bytes.data(), bytes.size());
  }
}

std::size_t buffer_bytes(const DicomPixels& pixels) {
  return is_plain(pixels) ? bytes_of_frame(pixels) : 3 * bytes_of_file(pixels);
}

DicomFrames::DicomFrames(const std::vector<DicomSlice>& slices) {
  std::vector<CompressedFile> compressed;  // in reading order
  std::filesystem::path first;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const bool opens = i == 0 || slices[i].file != slices[i - 1].file;
    if (!opens || is_plain(slices[i].pixels)) continue;
    if (compressed.empty()) first = slices[i].file;
    compressed.emplace_back(std::filesystem::absolute(slices[i].file), slices[i].pixels);
  }
  if (compressed.empty()) return;
  decoder_ = std::make_unique<WorkerRequest>(packed_request(kDicomPixels, first, compressed), first,
                                             decoding_limits(compressed));
  compressed_left_ = compressed.size();
}

DicomFrames::~DicomFrames() = default;

void DicomFrames::open(const DicomSlice& slice) {
  file_ = slice.file;
  pixels_ = slice.pixels;
  pixels_.plain = is_plain(pixels_);
  stored_type_ = stored_type_of(pixels_);
  frame_bytes_ = bytes_of_frame(pixels_);
  if (!pixels_.plain) return receive_decoded(slice);
  stream_ = std::ifstream(slice.file, std::ios::binary);
  buffer_.resize(frame_bytes_);
}

void DicomFrames::receive_decoded(const DicomSlice& slice) {
  try {
    buffer_.resize(bytes_of_file(pixels_));
    decoder_->read(buffer_.data(), buffer_.size());
    if (--compressed_left_ == 0) decoder_->finish();
  } catch (const WorkerFailure& failure) {
    fail(slice, failure.what());
  }
}

const std::byte* DicomFrames::stored(const DicomSlice& slice) {
  if (slice.file != file_) open(slice);
  const auto frame = static_cast<std::size_t>(slice.frame);
  if (!pixels_.plain) return buffer_.data() + frame * frame_bytes_;
  const auto read_bytes = [&](std::size_t at, char* to, std::size_t bytes) {
    stream_.seekg(static_cast<std::streamoff>(pixels_.start + at));
    if (!stream_.read(to, static_cast<std::streamsize>(bytes)))
      fail(slice, "truncated: the file ends before its pixel data");
  };
  const auto fill = [&](std::size_t at, char* to, std::size_t bytes) {
    if (!pixels_.in_words) return read_bytes(at, to, bytes);
    std::vector<std::byte> words((at % 2 + bytes + 1) / 2 * 2);
    read_bytes(at - at % 2, reinterpret_cast<char*>(words.data()), words.size());
    swap_bytes<std::uint16_t>(words);
    std::memcpy(to, words.data() + at % 2, bytes);
  };
  if (pixels_.bits == 1) {
    const std::size_t first = frame * frame_bytes_;
    std::vector<char> packed((first % 8 + frame_bytes_ + 7) / 8);
    fill(first / 8, packed.data(), packed.size());
    unpack_bits(packed, first, buffer_);
    return buffer_.data();
  }
  fill(frame * frame_bytes_, reinterpret_cast<char*>(buffer_.data()), frame_bytes_);
  visit_voxel_type(stored_type_, [&]<class T>(std::type_identity<T>) {
    if (pixels_.big_endian) swap_bytes<T>(buffer_);
    if constexpr (std::is_integral_v<T>) mask_stored_bits<T>(buffer_.data(), pixels_of_frame(pixels_), pixels_);
  });
  return buffer_.data();
}

bool DicomFrames::read(const DicomSlice& slice, VoxelType type, void* to) {
  const std::byte* from = stored(slice);
  const bool is_unscaled = slice.slope == 1 && slice.intercept == 0;
  bool fits = true;
  visit_voxel_type(stored_type_, [&]<class From>(std::type_identity<From>) {
    const auto* first = reinterpret_cast<const From*>(from);
    const From* last = first + pixels_of_frame(pixels_);
    visit_voxel_type(type, [&]<class To>(std::type_identity<To>) {
      if (slice.modality_lut) {
        const std::vector<std::uint16_t>& lut = *slice.modality_lut;
        std::transform(first, last, static_cast<To*>(to), [&](From v) {
          const double place = static_cast<double>(v) - slice.lut_begin;
          return static_cast<To>(lut[static_cast<std::size_t>(std::clamp(place, 0.0, double(lut.size() - 1)))]);
        });
      } else if (is_unscaled) {
        std::transform(first, last, static_cast<To*>(to), [](From v) { return static_cast<To>(v); });
      } else {
        // A codec can return more bits than the header states, so values can exceed the range of `type`.
        std::transform(first, last, static_cast<To*>(to), [&](From v) {
          const double value = slice.slope * static_cast<double>(v) + slice.intercept;
          const double clamped =
              std::clamp(value, double(std::numeric_limits<To>::lowest()), double(std::numeric_limits<To>::max()));
          fits &= clamped == value;
          return static_cast<To>(clamped);
        });
      }
    });
  });
  return fits;
}

}  // namespace simplexseg
