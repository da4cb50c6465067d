// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_validation.h"

#include <gdcmReader.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "core/number_text.h"
#include "io/dicom/dicom_requests.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// Random access to the bytes of a file through a buffer.
class Bytes {
 public:
  explicit Bytes(const fs::path& path) : stream_(path, std::ios::binary), size_(fs::file_size(path)) {}
  /// Replaces the bytes from `at` on by their decompressed form. Returns false when they cannot be decompressed.
  bool inflate_from(std::uint64_t at) {
    if (at > size_) return false;
    const unsigned char* compressed = get(at, static_cast<std::size_t>(size_ - at));
    if (!compressed) return false;
    std::vector<unsigned char> whole(at);
    z_stream state{};
    if (inflateInit2(&state, -MAX_WBITS) != Z_OK) return false;
    state.next_in = const_cast<unsigned char*>(compressed);
    state.avail_in = static_cast<uInt>(std::min<std::uint64_t>(size_ - at, 1u << 30));
    int result = Z_OK;
    while (result == Z_OK) {
      whole.resize(whole.size() + (1 << 16));
      state.next_out = whole.data() + whole.size() - (1 << 16);
      state.avail_out = 1 << 16;
      result = inflate(&state, Z_NO_FLUSH);
    }
    whole.resize(whole.size() - state.avail_out);
    inflateEnd(&state);
    window_ = std::move(whole), start_ = 0, size_ = window_.size();
    return result == Z_STREAM_END || result == Z_BUF_ERROR;
  }
  std::uint64_t size() const { return size_; }
  /// Returns `count` bytes from `at` on, valid until the next call; nullptr when the file ends before or is unreadable.
  const unsigned char* get(std::uint64_t at, std::size_t count) {
    if (at > size_ || count > size_ - at) return nullptr;
    if (at < start_ || at + count > start_ + window_.size()) {
      start_ = at;
      window_.resize(
          static_cast<std::size_t>(std::min<std::uint64_t>(std::max<std::size_t>(count, 16384), size_ - at)));
      stream_.clear();
      stream_.seekg(static_cast<std::streamoff>(at));
      if (!stream_.read(reinterpret_cast<char*>(window_.data()), static_cast<std::streamsize>(window_.size())))
        return nullptr;
    }
    return window_.data() + (at - start_);
  }

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0, start_ = 0;
  std::vector<unsigned char> window_;
};

struct Coding {
  bool explicit_vr = true, big_endian = false;
};

struct FirstElement {
  std::uint64_t at = 0;  ///< offset of the first element: after the preamble, or 0
  Coding coding;
};

constexpr std::uint32_t kUndefined = 0xffffffff, kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd,
                        kPixels = 0x7fe00010;
constexpr std::uint64_t kToleratedBytes = 1 << 20;  ///< longest element that may exceed the end of the file, bytes

struct Element {
  std::uint32_t tag = 0, length = 0;
  std::array<char, 2> vr{};
  std::uint64_t value = 0;  ///< offset of the value
};

/// Parser of the elements of a file, which checks their lengths.
class HeaderParser {
 public:
  explicit HeaderParser(const fs::path& path) : bytes_(path) {}

  /// Returns the offset and encoding of the first element; nullopt when the file does not start like DICOM.
  std::optional<FirstElement> first_element() {
    const unsigned char* magic = bytes_.get(128, 4);
    const std::uint64_t at = magic && std::memcmp(magic, "DICM", 4) == 0 ? 132 : 0;
    const unsigned char* start = bytes_.get(at, 8);
    if (!start) return {};
    Coding coding;
    coding.big_endian = start[0] == 0;
    const unsigned group = coding.big_endian ? start[1] : start[0];
    if ((group != 2 && group != 8) || start[0] + start[1] != static_cast<int>(group)) return {};
    const auto is_upper = [](unsigned char c) { return c >= 'A' && c <= 'Z'; };
    coding.explicit_vr = is_upper(start[4]) && is_upper(start[5]);
    return FirstElement{at, coding};
  }

  /// Returns a description of the damage, or an empty text.
  std::string check() {
    const auto first = first_element();
    if (!first) return "it does not start like a DICOM file";
    auto [at, coding] = *first;
    while (const unsigned char* head = bytes_.get(at, 2)) {
      if (number(head, 2, coding.big_endian) != 2) break;  // the data set after group 2 can have another encoding
      const auto e = element(at, coding);
      if (!e || !fits(*e)) return damage_;
      if (e->tag == 0x00020010) data_set_coding_ = coding_named(*e);
      at = e->value + e->length;
    }
    guessed_ = first->at > 0 && !data_set_coding_;
    if (deflated_ && !bytes_.inflate_from(at)) return "its deflated data is damaged";
    data_set(at, bytes_.size(), data_set_coding_.value_or(coding), 0);
    return damage_;
  }
  /// Returns true for a file with preamble but without transfer syntax. GDCM guesses its encoding, and the guess can
  /// differ from that of check().
  bool is_guessed() const { return guessed_; }

 private:
  std::uint32_t number(const unsigned char* from, int count, bool big_endian) const {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) value |= std::uint32_t(from[big_endian ? count - 1 - i : i]) << (8 * i);
    return value;
  }

  Coding coding_named(const Element& e) {
    std::string uid;
    if (const unsigned char* text = e.length < 100 ? bytes_.get(e.value, e.length) : nullptr)
      uid.assign(text, text + e.length);
    uid.erase(std::find_if(uid.begin(), uid.end(), [](char c) { return c == '\0' || c == ' '; }), uid.end());
    deflated_ = uid == "1.2.840.10008.1.2.1.99";
    compressed_ = uid.starts_with("1.2.840.10008.1.2.4") || uid.starts_with("1.2.840.10008.1.2.5");
    return {uid != "1.2.840.10008.1.2", uid == "1.2.840.10008.1.2.2"};
  }

  /// Returns the element at offset `at`. Returns nullopt at the end of the file, and for an invalid element after
  /// recording the damage.
  std::optional<Element> element(std::uint64_t at, const Coding& coding) {
    const unsigned char* head = bytes_.get(at, 8);
    if (!head) return {};
    Element e;
    e.tag = number(head, 2, coding.big_endian) << 16 | number(head + 2, 2, coding.big_endian);
    e.value = at + 8;
    if (!coding.explicit_vr || e.tag >> 16 == 0xfffe) {
      e.length = number(head + 4, 4, coding.big_endian);
      return e;
    }
    e.vr = {static_cast<char>(head[4]), static_cast<char>(head[5])};
    const auto is_one_of = [&](std::string_view list) {
      for (std::size_t i = 0; i < list.size(); i += 2) {
        if (list.compare(i, 2, e.vr.data(), 2) == 0) return true;
      }
      return false;
    };
    if (is_one_of("AEASATCSDADSDTFLFDISLOLTPNSHSLSSSTTMUIULUS")) {
      e.length = number(head + 6, 2, coding.big_endian);
      return e;
    }
    if (!is_one_of("OBOWOFODOLOVSQUNUCURUTSVUV")) {  // GDCM would read the next bytes as a length
      report_damage_at(at);
      return {};
    }
    const unsigned char* rest = bytes_.get(at + 8, 4);
    if (!rest) return {};
    e.length = number(rest, 4, coding.big_endian);
    e.value = at + 12;
    return e;
  }

  void report_damage_at(std::uint64_t at) {
    if (after_pixels_ && !deflated_) return;  // padding after the pixels is not read
    if (damage_.empty()) damage_ = "its header is damaged at byte " + std::to_string(at);
  }

  bool fits(const Element& e) {
    const std::uint64_t left = bytes_.size() - std::min(bytes_.size(), e.value);
    if (e.length <= left || e.length <= kToleratedBytes) return true;
    const std::string text = "damaged: element (" + hexadecimal_text(e.tag >> 16, 4) + "," +
                             hexadecimal_text(e.tag & 0xffff, 4) + ") claims " + format_bytes(double(e.length)) +
                             ", but only " + format_bytes(double(left)) + " remain";
    if (damage_.empty()) damage_ = text;
    return false;
  }

  bool begins_with_item(const Element& e, const Coding& coding) {
    const unsigned char* head = bytes_.get(e.value, 4);
    return head && e.length >= 8 &&
           (number(head, 2, coding.big_endian) << 16 | number(head + 2, 2, coding.big_endian)) == kItem;
  }

  /// Returns the offset after the pixel fragments. Truncated fragments are reported by damage_of_fragments().
  std::uint64_t after_fragments(std::uint64_t at) {
    while (const unsigned char* head = bytes_.get(at, 8)) {
      const std::uint32_t tag = number(head, 2, false) << 16 | number(head + 2, 2, false);
      at += 8;
      if (tag != kItem) break;
      at += number(head + 4, 4, false);
    }
    return at;
  }

  /// Parses elements up to `end`, or to the delimiter of an item of undefined length. Returns the offset after them, or
  /// the end of the file after an error.
  std::uint64_t data_set(std::uint64_t at, std::uint64_t end, const Coding& coding, int depth) {
    while (at < end) {
      const auto e = element(at, coding);
      if (!e) return bytes_.size();
      if (e->tag == kItemEnd || e->tag == kSequenceEnd) return e->value;
      if (e->tag == kPixels && depth == 0) {
        // GDCM allocates memory for deflated or compressed pixels at once. It does not read others (dicom_pixels.cpp).
        if ((deflated_ || compressed_) && e->length != kUndefined && !fits(*e)) return bytes_.size();
        at = e->length == kUndefined ? after_fragments(e->value) : e->value + e->length;
        after_pixels_ = true;
        continue;
      }
      const bool is_sequence =
          e->length == kUndefined || std::memcmp(e->vr.data(), "SQ", 2) == 0 ||
          ((!coding.explicit_vr || std::memcmp(e->vr.data(), "UN", 2) == 0) && begins_with_item(*e, coding));
      if (e->length != kUndefined && !fits(*e)) return bytes_.size();
      if (is_sequence) {
        Coding nested = coding;
        if (std::memcmp(e->vr.data(), "UN", 2) == 0) nested.explicit_vr = false;
        const bool fragments = e->tag == kPixels || e->vr[0] == 'O';  // compressed pixels, e.g. of an icon
        items(e->value, e->length, nested, fragments, depth);
        if (!damage_.empty()) return bytes_.size();
      }
      const std::uint64_t next = e->length == kUndefined ? after_ : e->value + e->length;
      if (next <= at) return bytes_.size();  // padding of unknown length after the pixels
      at = next;
    }
    return at;
  }

  /// Parses the items of a sequence, or skips fragments. Sets `after_` to the offset after the sequence.
  void items(std::uint64_t at, std::uint32_t length, const Coding& coding, bool fragments, int depth) {
    const std::uint64_t end = length == kUndefined ? bytes_.size() : std::min(bytes_.size(), at + length);
    if (depth > 30) return report_damage_at(at);
    while (at < end) {
      const auto e = element(at, coding);
      if (!e) break;
      if (e->tag == kSequenceEnd) {
        after_ = e->value;
        return;
      }
      if (e->tag != kItem) return report_damage_at(at);
      if (e->length != kUndefined && !fits(*e)) return;
      const std::uint64_t item_end = e->length == kUndefined ? bytes_.size() : e->value + e->length;
      if (fragments) {
        if (e->length == kUndefined) return report_damage_at(at);
        at = item_end;
        continue;
      }
      const std::uint64_t next = data_set(e->value, std::min(item_end, bytes_.size()), coding, depth + 1);
      if (!damage_.empty()) return;
      at = e->length == kUndefined ? next : item_end;
    }
    after_ = end;
  }

  Bytes bytes_;
  std::optional<Coding> data_set_coding_;
  bool deflated_ = false, compressed_ = false, guessed_ = false, after_pixels_ = false;
  std::uint64_t after_ = 0;
  std::string damage_;
};

/// Returns true when GDCM reads the header within the default limits of a request.
bool gdcm_reads(const fs::path& path) {
  try {
    return request_result(kDicomIsReadable, path, {});
  } catch (const WorkerFailure&) {
    return false;
  }
}

/// Header of a compressed frame.
struct CompressedImage {
  std::uint64_t columns = 0, rows = 0;
  double max_ratio = 1;  ///< upper bound of the compression ratio
};

/// Parses the header of a compressed frame; nullopt for unknown formats.
std::optional<CompressedImage> compressed_image(const unsigned char* head, std::size_t count) {
  const auto number = [&](std::size_t at, int bytes) {
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) value = value << 8 | head[at + static_cast<std::size_t>(i)];
    return value;
  };
  for (std::size_t i = 0; i + 24 <= std::min<std::size_t>(count, 300); ++i) {  // JPEG 2000, as codestream or in boxes
    if (number(i, 4) != 0xff4fff51) continue;
    return CompressedImage{number(i + 8, 4) - number(i + 16, 4), number(i + 12, 4) - number(i + 20, 4), 1000};
  }
  if (count < 4 || number(0, 2) != 0xffd8) return {};
  for (std::size_t i = 2; i + 9 <= count && head[i] == 0xff;) {
    const unsigned marker = head[i + 1];
    if (marker == 0xff) {
      ++i;
      continue;
    }
    const bool is_frame = (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc);
    if (is_frame || marker == 0xf7)
      return CompressedImage{number(i + 7, 2), number(i + 5, 2), marker == 0xf7 ? 1000.0 : 200.0};
    i += 2 + static_cast<std::size_t>(number(i + 2, 2));
  }
  return {};
}

}  // namespace

bool in_reader::is_readable_dicom(const fs::path& path) {
  const gdcm::Tag pixels(0x7fe0, 0x0010);
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  return reader.ReadUpToTag(pixels, {pixels});
}

bool has_dicom_header(const fs::path& path) {
  const auto first = HeaderParser(path).first_element();
  return first && (first->at > 0 || gdcm_reads(path));
}

std::string damage_of_header(const fs::path& path) {
  HeaderParser parser(path);
  const std::string damage = parser.check();
  return damage.empty() && parser.is_guessed() && !gdcm_reads(path) ? "its header is damaged" : damage;
}

std::string damage_of_fragments(const fs::path& path, const DicomPixels& pixels) {
  constexpr const char* truncated = "truncated: the file ends before its pixel data";
  constexpr double tolerated = 64e6;
  constexpr double runs = 64;  // two bytes of run-length coding expand to at most 128 bytes
  Bytes bytes(path);
  std::uint64_t at = pixels.start;
  int fragments = 0;
  double max_bytes = 0;
  bool ended = false;
  while (const unsigned char* head = bytes.get(at, 8)) {
    std::uint32_t tag = 0, length = 0;
    std::memcpy(&tag, head, 4);
    std::memcpy(&length, head + 4, 4);
    if (tag == 0xe0ddfffe) ended = true;
    if (tag != 0xe000fffe) break;
    at += 8;
    const std::uint64_t left = bytes.size() - at;
    if (length > left) return truncated;
    if (fragments > 0) {
      const std::size_t count = std::min<std::size_t>(length, 4096);
      const unsigned char* start = bytes.get(at, count);
      const auto image = start ? compressed_image(start, count) : std::nullopt;
      if (image && (image->columns != static_cast<std::uint64_t>(pixels.columns) ||
                    image->rows != static_cast<std::uint64_t>(pixels.rows))) {
        return "its compressed image has " + std::to_string(image->columns) + " x " + std::to_string(image->rows) +
               " pixels, but its header states " + std::to_string(pixels.columns) + " x " + std::to_string(pixels.rows);
      }
      max_bytes += double(length) * (image ? image->max_ratio : runs);
    }
    ++fragments;
    at += length;
  }
  if (!ended && at != bytes.size()) return truncated;  // some writers omit the closing delimiter
  if (fragments - 1 < pixels.frames)
    return "truncated: it contains only " + std::to_string(std::max(fragments - 1, 0)) + " of its " +
           std::to_string(pixels.frames) + " frames";
  const double required =
      double(pixels.rows) * pixels.columns * pixels.samples * pixels.frames * ((pixels.bits + 7) / 8);
  if (required > tolerated && required > max_bytes) {
    return "its header requires " + format_bytes(required) +
           ", but its compressed pixels are too small to hold more than " + format_bytes(max_bytes);
  }
  return {};
}

}  // namespace simplexseg
