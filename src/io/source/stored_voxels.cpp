// SPDX-License-Identifier: Apache-2.0
#include "io/source/stored_voxels.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/platform/load_progress.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr const char* kExportAgain = "copy or export the file again";
constexpr std::size_t kMaxDigits = 1100;      // more than the exact decimal value of any double has
constexpr std::size_t kVoxelBlock = 1 << 18;  // voxels per conversion step

void swap_bytes(unsigned char* data, std::size_t count, int size) {
  for (std::size_t i = 0; i < count; ++i, data += size) std::reverse(data, data + size);
}

/// Calls f with the C++ type of the stored voxels.
template <class F>
void visit_stored(const StoredType& stored, F&& f) {
  if (stored.wide && stored.type == VoxelType::Int32) return f(std::type_identity<std::int64_t>{});
  if (stored.wide) return f(std::type_identity<std::uint64_t>{});
  visit_voxel_type(stored.type, f);
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Stream of the voxels of all files in reading order, converted to binary numbers.
class VoxelBytes {
 public:
  VoxelBytes(const StoredVoxels& voxels, std::size_t count)
      : voxels_(voxels), per_file_(count / voxels.files.size()), text_(1 << 16, '\0') {}

  /// Reads `voxels` voxels. Throws Error when the current file ends before.
  void read(unsigned char* to, std::size_t voxels) {
    while (voxels > 0) {
      if (left_ == 0) open_next();
      const std::size_t now = std::min(voxels, left_), bytes = now * static_cast<std::size_t>(voxels_.type.bytes);
      switch (voxels_.encoding) {
        case VoxelEncoding::Binary: {
          const std::size_t got = reader_->read(to, bytes);
          if (got != bytes) throw_early_end(got);
          break;
        }
        case VoxelEncoding::Hexadecimal:
          read_hexadecimal(to, bytes);
          break;
        case VoxelEncoding::Text:
          read_text(to, now);
          break;
      }
      to += bytes;
      voxels -= now;
      left_ -= now;
    }
  }
  /// Skips `voxels` voxels. Throws Error when the current file ends before.
  void skip(std::size_t voxels) {
    std::vector<unsigned char> unread;
    while (voxels > 0) {
      if (left_ == 0 && voxels >= per_file_) {  // skips the whole file
        ++next_;
        voxels -= per_file_;
        continue;
      }
      if (left_ == 0) open_next();
      const std::size_t size = static_cast<std::size_t>(voxels_.type.bytes);
      std::size_t now = std::min(voxels, left_);
      if (voxels_.encoding == VoxelEncoding::Binary) {
        if (!reader_->skip(std::uint64_t{now} * size)) throw_early_end(0);
        left_ -= now;
      } else {
        now = std::min(now, kVoxelBlock);
        unread.resize(now * size);
        read(unread.data(), now);
      }
      voxels -= now;
    }
  }
  /// Throws Error when all voxels of the current file are read and its checksum is wrong or its end is missing.
  void require_valid_checksum() const {
    if (reader_ && left_ == 0 && reader_->damaged_at_end()) throw_damaged();
  }

 private:
  const fs::path& file() const { return voxels_.files[next_ - 1]; }

  void open_next() {
    require_valid_checksum();
    const fs::path& file = voxels_.files[next_++];
    const std::uint64_t bytes = per_file_ * static_cast<std::uint64_t>(voxels_.type.bytes);
    const std::uint64_t size = voxels_.at_end ? fs::file_size(file) : 0;
    reader_ =
        std::make_unique<DecompressingReader>(file, voxels_.compression, size > bytes ? size - bytes : voxels_.offset);
    left_ = per_file_;
    first_ = last_ = 0;
    if (!reader_->skip(voxels_.skipped)) throw_early_end(0);
  }

  [[noreturn]] void throw_damaged() const {
    throw Error("cannot read " + quoted(file()), "its compressed data is damaged", kExportAgain);
  }

  [[noreturn]] void throw_early_end(std::size_t got) const {
    if (reader_->damaged()) throw_damaged();
    const auto size = static_cast<double>(voxels_.type.bytes), before = static_cast<double>(voxels_.skipped);
    throw_truncated(file(), before + size * static_cast<double>(per_file_),
                    before + size * static_cast<double>(per_file_ - left_) + static_cast<double>(got));
  }

  /// Returns the next character of the current file; 0 at its end.
  char next_character() {
    if (first_ == last_) first_ = 0, last_ = reader_->read(text_.data(), text_.size());
    return first_ == last_ ? '\0' : text_[first_++];
  }

  void read_hexadecimal(unsigned char* to, std::size_t bytes) {
    for (std::size_t digit = 0; digit < 2 * bytes; ++digit) {
      char c = next_character();
      while (is_space(c)) c = next_character();
      const int value = hex_digit(c);
      if (c == '\0') throw_early_end(digit / 2);
      if (value < 0)
        throw Error("cannot read " + quoted(file()), "a voxel contains an invalid hexadecimal digit", kExportAgain);
      if (digit % 2 == 0)
        to[digit / 2] = static_cast<unsigned char>(16 * value);
      else
        to[digit / 2] = static_cast<unsigned char>(to[digit / 2] + value);
    }
  }

  void read_text(unsigned char* to, std::size_t voxels) {
    visit_stored(voxels_.type, [&]<class T>(std::type_identity<T>) {
      T* const values = reinterpret_cast<T*>(to);
      for (std::size_t v = 0; v < voxels; ++v) values[v] = next_number<T>(v);
    });
  }

  template <class T>
  T next_number(std::size_t before) {
    const auto separates = [](char c) { return c == ',' || is_space(c); };
    char c = next_character();
    while (separates(c)) c = next_character();
    if (c == '\0') throw_early_end(before * sizeof(T));
    std::string word;
    for (; c != '\0' && !separates(c); c = next_character()) {
      if (word.size() < kMaxDigits) word += c;
      if (word.size() == kMaxDigits) word.back() = '?';  // not a number
    }
    const char* const begin = word.data() + (word[0] == '+' ? 1 : 0);
    const char* const end = word.data() + word.size();
    T value{};
    std::from_chars_result result{};
    if constexpr (std::is_floating_point_v<T>) {
      result = std::from_chars(begin, end, value);
    } else {
      std::int64_t whole = 0;  // int8 is parsed as a number, not as a character
      if constexpr (sizeof(T) == 8) {
        result = std::from_chars(begin, end, value);
      } else {
        result = std::from_chars(begin, end, whole);
        if (whole < std::numeric_limits<T>::min() || whole > std::numeric_limits<T>::max())
          result.ec = std::errc::result_out_of_range;
        value = static_cast<T>(whole);
      }
    }
    if (result.ec == std::errc() && result.ptr == end) return value;
    throw Error("cannot read " + quoted(file()), "the voxel '" + one_line(word) + "' is not a number of its type",
                kExportAgain);
  }

  const StoredVoxels& voxels_;
  const std::size_t per_file_;
  std::unique_ptr<DecompressingReader> reader_;
  std::size_t next_ = 0;  ///< index of the next file
  std::size_t left_ = 0;  ///< voxels of the current file not yet read
  std::string text_;
  std::size_t first_ = 0, last_ = 0;  ///< unused range of `text_`
};

/// Throws Error when a file is missing or too small for the volume size in the header.
void require_file_sizes(const StoredVoxels& voxels, const VolumeInfo& info, const fs::path& header) {
  double count = static_cast<double>(info.frames) * info.components;
  for (const int size : info.geometry.size) count *= size;
  const double per_file = count / static_cast<double>(voxels.files.size());
  double bytes = per_file * voxels.type.bytes;
  if (voxels.encoding == VoxelEncoding::Hexadecimal) bytes *= 2;
  if (voxels.encoding == VoxelEncoding::Text) bytes = 2 * per_file - 1;  // at least a digit and a separator per voxel
  for (const fs::path& file : voxels.files) {
    std::error_code error;
    if (!fs::exists(file, error)) {
      throw Error("cannot read " + quoted(header), "its voxel file " + quoted(file) + " is missing",
                  "move both files to one folder");
    }
    if (voxels.at_end) {
      const double size = static_cast<double>(fs::file_size(file)), before = static_cast<double>(voxels.offset);
      if (before + bytes > size) throw_truncated(file, before + bytes, size);
      continue;
    }
    const double required = static_cast<double>(voxels.skipped) + bytes;
    const double available = DecompressingReader(file, voxels.compression, voxels.offset).max_bytes();
    if (required > available) throw_truncated(file, required, available);
  }
}

/// Reads `count` voxels of volume `index` (from 0) of `volumes` interleaved volumes; the voxels of the others are
/// discarded.
void read_interleaved(VoxelBytes& bytes, unsigned char* to, std::size_t count, std::size_t volumes, std::size_t index,
                      std::size_t size) {
  if (volumes == 1) return bytes.read(to, count);
  const std::size_t at_once = std::max<std::size_t>(1, kVoxelBlock / volumes);
  std::vector<std::uint64_t> block((std::min(at_once, count) * volumes * size + 7) / 8);
  auto* const raw = reinterpret_cast<unsigned char*>(block.data());
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t n = std::min(at_once, count - first);
    bytes.read(raw, n * volumes);
    for (std::size_t i = 0; i < n; ++i) std::memcpy(to + (first + i) * size, raw + (i * volumes + index) * size, size);
  }
}

/// Reads the voxels of the selected volume, which must have one component.
Volume read_stored(const StoredVoxels& v, const VolumeInfo& info) {
  Volume volume(info.geometry, info.type);
  const std::size_t count = info.geometry.voxel_count();
  VoxelBytes bytes(v, count * static_cast<std::size_t>(info.frames));
  const auto interleaved = static_cast<std::size_t>(v.interleaved), size = static_cast<std::size_t>(v.type.bytes);
  const auto before = static_cast<std::size_t>(std::max(info.frame, 1) - 1);
  bytes.skip(before / interleaved * interleaved * count);
  const bool must_swap = v.swapped && v.type.bytes > 1 && v.encoding != VoxelEncoding::Text;
  if (!v.rescaled && !v.type.wide) {
    auto* const to = static_cast<unsigned char*>(volume.data());
    for (std::size_t first = 0; first < count; first += kVoxelBlock) {
      const std::size_t n = std::min(kVoxelBlock, count - first);
      auto* const block = to + first * size;
      read_interleaved(bytes, block, n, interleaved, before % interleaved, size);
      if (must_swap) swap_bytes(block, n, v.type.bytes);
      report_progress(static_cast<double>(first + n), static_cast<double>(count));
    }
  } else {
    std::vector<std::uint64_t> block(kVoxelBlock);  // uint64 for the alignment of the widest type
    auto* const raw = reinterpret_cast<unsigned char*>(block.data());
    for (std::size_t first = 0; first < count; first += kVoxelBlock) {
      const std::size_t n = std::min(kVoxelBlock, count - first);
      read_interleaved(bytes, raw, n, interleaved, before % interleaved, size);
      report_progress(static_cast<double>(first + n), static_cast<double>(count));
      if (must_swap) swap_bytes(raw, n, v.type.bytes);
      visit_stored(v.type, [&]<class From>(std::type_identity<From>) {
        const auto* const from = reinterpret_cast<const From*>(raw);
        visit_voxel_type(info.type, [&]<class To>(std::type_identity<To>) {
          To* const to = volume.voxels<To>().data() + first;
          if constexpr (std::is_floating_point_v<To>) {
            for (std::size_t i = 0; i < n; ++i)
              to[i] = static_cast<To>(static_cast<double>(from[i]) * v.slope + v.intercept);
          } else if constexpr (sizeof(From) == 8 && sizeof(To) == 4 && std::is_integral_v<From>) {
            narrow(from, n, to, quoted(v.files.front()));
          }
        });
      });
    }
  }
  bytes.require_valid_checksum();
  return volume;
}

}  // namespace

StoredType stored_integer(int bytes, bool has_sign) {
  switch (bytes) {
    case 1:
      return {1, has_sign ? VoxelType::Int8 : VoxelType::UInt8};
    case 2:
      return {2, has_sign ? VoxelType::Int16 : VoxelType::UInt16};
    case 4:
      return {4, has_sign ? VoxelType::Int32 : VoxelType::UInt32};
    default:
      return {8, has_sign ? VoxelType::Int32 : VoxelType::UInt32, true};
  }
}

VolumeSource open_stored(VolumeInfo info, StoredVoxels voxels, const fs::path& header, int volume) {
  info.geometry.validate("cannot read " + quoted(header));
  warn_if_sheared(info);
  const VoxelType stored = voxels.type.type;
  const bool is_float = stored == VoxelType::Float32 || stored == VoxelType::Float64;
  info.type = voxels.rescaled && !is_float ? VoxelType::Float32 : stored;
  if (voxels.type.wide && !voxels.rescaled) info.warnings.push_back("64-bit integers are converted to 32 bits");
  require_file_sizes(voxels, info, header);
  if (info.components == 1 && voxels.interleaved > 0) select_volume(info, volume, "cannot read " + quoted(header));
  VolumeSource source;
  source.info = info;
  source.read = [voxels = std::move(voxels), info = std::move(info)] { return read_stored(voxels, info); };
  return source;
}

double count_of_slices(std::span<const std::int64_t> sizes, std::int64_t dimension) {
  double count = 1;
  for (const std::int64_t size : sizes.subspan(static_cast<std::size_t>(dimension))) count *= static_cast<double>(size);
  return count;
}

std::vector<fs::path> listed_files(const fs::path& header, const std::vector<std::string>& names, double slices) {
  if (static_cast<double>(names.size()) != slices)
    throw Error("cannot read " + quoted(header),
                "it lists " + counted(static_cast<std::int64_t>(names.size()), "file") + " for " + digits_of(slices) +
                    (slices == 1 ? " slice" : " slices"),
                "correct its header");
  std::vector<fs::path> files;
  files.reserve(names.size());
  for (const std::string& name : names) files.push_back(header.parent_path() / name);
  return files;
}

std::vector<fs::path> numbered_files(const fs::path& header, const std::string& pattern, long first, long step,
                                     int count) {
  const auto fail = [&] {
    throw Error("cannot read " + quoted(header),
                "its file name pattern '" + one_line(pattern) + "' does not contain exactly one number such as %03d",
                "correct its header");
  };
  const std::size_t percent = pattern.find('%');
  if (percent == std::string::npos || pattern.find('%', percent + 1) != std::string::npos) fail();
  std::size_t end = percent + 1;
  const char blank = end < pattern.size() && pattern[end] == '0' ? '0' : ' ';
  std::size_t width = 0;
  for (; end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9' && width < 100; ++end)
    width = 10 * width + static_cast<std::size_t>(pattern[end] - '0');
  if (end >= pattern.size() || width >= 100 || std::string("diu").find(pattern[end]) == std::string::npos) fail();
  std::vector<fs::path> files;
  for (int n = 0; n < count; ++n) {
    std::string number = std::to_string(first + n * step);
    if (number.size() < width) number.insert(0, width - number.size(), blank);
    files.push_back(header.parent_path() / (pattern.substr(0, percent) + number + pattern.substr(end + 1)));
  }
  return files;
}

}  // namespace simplexseg
