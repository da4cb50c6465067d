// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_pixels.h"

#include <gdcmPixmapReader.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

#include "io/child_process.h"
#include "io/files.h"
#include "io/quiet_libraries.h"

namespace simplexseg {
namespace {

constexpr const char* kBeyondBounds = "its pixels are damaged: they cannot be decoded within bounds of time and memory";
constexpr std::size_t kMostWords = 1000;  // characters

VoxelType stored_type_of(const DicomPixels& p) {
  if (p.bits <= 8) return p.is_signed ? VoxelType::Int8 : VoxelType::UInt8;
  if (p.bits <= 16) return p.is_signed ? VoxelType::Int16 : VoxelType::UInt16;
  return p.is_signed ? VoxelType::Int32 : VoxelType::UInt32;
}

[[noreturn]] void refuse(const DicomSlice& slice, const std::string& why) {
  throw Error("cannot read " + quoted(slice.file), why, "copy or export the file again");
}

std::size_t pixels_of_frame(const DicomPixels& p) {
  return static_cast<std::size_t>(p.rows) * static_cast<std::size_t>(p.columns);
}

std::size_t bytes_of_frame(const DicomPixels& p) { return pixels_of_frame(p) * bytes_per_voxel(stored_type_of(p)); }
std::size_t bytes_of_file(const DicomPixels& p) { return bytes_of_frame(p) * static_cast<std::size_t>(p.frames); }

/// Whether the pixels are read as they lie in the file.
bool is_plain(const DicomPixels& p) { return p.plain && (p.bits == 1 || p.bits == 8 || p.bits == 16 || p.bits == 32); }

/// All frames of a file; throws std::runtime_error that says why there are none.
std::vector<char> decode(const DicomSlice& slice) {
  std::vector<char> bytes(bytes_of_file(slice.pixels));
  without_aborting([&] {
    gdcm::PixmapReader reader;
    reader.SetFileName(slice.file.c_str());
    if (!reader.Read()) throw std::runtime_error("its header or its pixels are damaged");
    const gdcm::Pixmap& pixmap = reader.GetPixmap();
    if (pixmap.GetBufferLength() != bytes.size())
      throw std::runtime_error("its pixels are not of the size and type that its header says");
    if (!pixmap.GetBuffer(bytes.data())) throw std::runtime_error("its pixels are damaged");
  });
  return bytes;
}

/// In the decoder: how many characters say what is wrong, and these, or 0 and the bytes of the frames.
void decode_to(int pipe, const DicomSlice& slice) {
  std::string why;
  std::vector<char> bytes;
  try {
    bytes = decode(slice);
  } catch (const std::bad_alloc&) {
    why = kBeyondBounds;
  } catch (const std::exception& exception) {
    why = plain_words(exception).substr(0, kMostWords);
  }
  const std::size_t words = why.size();
  write_to_parent(pipe, &words, sizeof words);
  why.empty() ? write_to_parent(pipe, bytes.data(), bytes.size()) : write_to_parent(pipe, why.data(), words);
}

/// For a file what it unpacks to is bounded already (damage_of_fragments()).
ChildLimits limits_for(const std::vector<DicomSlice>& files) {
  constexpr double packed_bytes_in_a_second = 5e5;  // the slowest codecs unpack many times that
  ChildLimits limits;
  double most = 0, packed = 0;
  for (const DicomSlice& slice : files) {
    const auto size = static_cast<double>(std::filesystem::file_size(slice.file));
    most = std::max(most, 6 * static_cast<double>(bytes_of_file(slice.pixels)) + 4 * size);
    packed += size;
  }
  limits.memory_bytes += static_cast<std::size_t>(most);
  limits.cpu_seconds += static_cast<int>(std::min(packed / packed_bytes_in_a_second, 1e6));
  return limits;
}

/// The pixels of a frame of bits, which begin anywhere in a byte.
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

/// Other bits of a pixel than those from the high bit down (overlays) are taken away, and the sign is restored.
template <class T>
void keep_stored_bits(std::byte* bytes, std::size_t count, const DicomPixels& p) {
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
  if (slice.slope == 1 && slice.intercept == 0) return stored_type_of(p);
  const VoxelType real = p.stored_bits > 24 ? VoxelType::Float64 : VoxelType::Float32;
  if (slice.slope != std::rint(slice.slope) || slice.intercept != std::rint(slice.intercept)) return real;
  const int bits = std::clamp(p.stored_bits, 1, 32);
  const double low = p.is_signed ? -std::ldexp(1.0, bits - 1) : 0, span = std::ldexp(1.0, bits) - 1;
  if (bits == 16 && slice.slope == 1 && std::abs(slice.intercept) <= 32768 && (p.is_signed || slice.intercept < 0))
    return VoxelType::Int16;
  const double a = slice.slope * low + slice.intercept, b = slice.slope * (low + span) + slice.intercept;
  const double least = std::min(a, b), most = std::max(a, b);
  for (const VoxelType type :
       {VoxelType::UInt8, VoxelType::Int8, VoxelType::UInt16, VoxelType::Int16, VoxelType::UInt32, VoxelType::Int32}) {
    const bool holds = visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      return least >= double(std::numeric_limits<T>::lowest()) && most <= double(std::numeric_limits<T>::max());
    });
    if (holds) return type;
  }
  return real;
}

std::size_t buffer_bytes(const DicomPixels& pixels) {
  return is_plain(pixels) ? bytes_of_frame(pixels) : 3 * bytes_of_file(pixels);
}

DicomFrames::DicomFrames(const std::vector<DicomSlice>& slices) {
  std::vector<DicomSlice> packed;  // one for each time that a file is opened
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const bool opens = i == 0 || slices[i].file != slices[i - 1].file;
    if (opens && !is_plain(slices[i].pixels)) packed.push_back(slices[i]);
  }
  if (packed.empty()) return;
  decoder_ = std::make_unique<ChildProcess>(limits_for(packed), [&packed](int pipe) {
    for (const DicomSlice& slice : packed) decode_to(pipe, slice);
  });
}

DicomFrames::~DicomFrames() = default;

void DicomFrames::open(const DicomSlice& slice) {
  file_ = slice.file;
  pixels_ = slice.pixels;
  pixels_.plain = is_plain(pixels_);
  stored_type_ = stored_type_of(pixels_);
  frame_bytes_ = bytes_of_frame(pixels_);
  if (!pixels_.plain) return take_decoded(slice);
  stream_ = std::ifstream(slice.file, std::ios::binary);
  buffer_.resize(frame_bytes_);
}

void DicomFrames::take_decoded(const DicomSlice& slice) {
  std::size_t words = 0;
  bool there = decoder_->read(&words, sizeof words);
  if (there && words > 0) {
    std::string why(std::min(words, kMostWords), '\0');
    if (decoder_->read(why.data(), why.size())) refuse(slice, why);
    there = false;
  }
  if (there) {
    buffer_.resize(bytes_of_file(pixels_));
    there = decoder_->read(buffer_.data(), buffer_.size());
  }
  if (!there) refuse(slice, kBeyondBounds);
}

const std::byte* DicomFrames::stored(const DicomSlice& slice) {
  if (slice.file != file_) open(slice);
  const auto frame = static_cast<std::size_t>(slice.frame);
  if (!pixels_.plain) return buffer_.data() + frame * frame_bytes_;
  const auto fill = [&](std::size_t at, char* to, std::size_t bytes) {
    stream_.seekg(static_cast<std::streamoff>(pixels_.start + at));
    if (!stream_.read(to, static_cast<std::streamsize>(bytes)))
      refuse(slice, "truncated: the file ends before its pixels do");
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
    if constexpr (std::is_integral_v<T>) keep_stored_bits<T>(buffer_.data(), pixels_of_frame(pixels_), pixels_);
  });
  return buffer_.data();
}

bool DicomFrames::read(const DicomSlice& slice, VoxelType type, void* to) {
  const std::byte* from = stored(slice);
  const bool same = slice.slope == 1 && slice.intercept == 0;
  bool fits = true;
  visit_voxel_type(stored_type_, [&]<class From>(std::type_identity<From>) {
    const auto* first = reinterpret_cast<const From*>(from);
    const From* last = first + pixels_of_frame(pixels_);
    visit_voxel_type(type, [&]<class To>(std::type_identity<To>) {
      if (same) {
        std::transform(first, last, static_cast<To*>(to), [](From v) { return static_cast<To>(v); });
      } else {
        // A codec can give more than the bits that the header names.
        std::transform(first, last, static_cast<To*>(to), [&](From v) {
          const double value = slice.slope * static_cast<double>(v) + slice.intercept;
          const double held =
              std::clamp(value, double(std::numeric_limits<To>::lowest()), double(std::numeric_limits<To>::max()));
          fits &= held == value;
          return static_cast<To>(held);
        });
      }
    });
  });
  return fits;
}

}  // namespace simplexseg
