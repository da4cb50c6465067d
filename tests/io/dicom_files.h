// SPDX-License-Identifier: Apache-2.0
// DICOM files for the tests, built byte by byte.
#pragma once
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "core/number_text.h"

namespace simplexseg::test {

inline const char* const kExplicitLittle = "1.2.840.10008.1.2.1";
inline const char* const kImplicitLittle = "1.2.840.10008.1.2";
inline const char* const kRle = "1.2.840.10008.1.2.5";
inline const char* const kEnhancedMr = "1.2.840.10008.5.1.4.1.1.4.1";

template <class... T>
std::string bytes_of_numbers(T... numbers) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return bytes;
}

/// Elements of a data set, to be added in the order of their tags.
struct DicomData {
  bool explicit_vr = true;
  std::string bytes{};

  DicomData& raw(std::uint16_t group, std::uint16_t element, const std::string& vr, std::string value) {
    if (value.size() % 2) value += vr == "UI" || vr == "OB" ? '\0' : ' ';
    head(group, element, vr, static_cast<std::uint32_t>(value.size()));
    bytes += value;
    return *this;
  }
  DicomData& text(std::uint16_t group, std::uint16_t element, const char* vr, const std::string& value) {
    return raw(group, element, vr, value);
  }
  DicomData& us(std::uint16_t group, std::uint16_t element, std::uint16_t value) {
    return raw(group, element, "US", bytes_of_numbers(value));
  }
  DicomData& fd(std::uint16_t group, std::uint16_t element, double value) {
    return raw(group, element, "FD", bytes_of_numbers(value));
  }
  DicomData& numbers(std::uint16_t group, std::uint16_t element, const std::vector<double>& values) {
    std::string value;
    for (const double v : values) {
      if (!value.empty()) value += '\\';
      value += general_text(v, 10);
    }
    return raw(group, element, "DS", value);
  }
  /// Adds a sequence; its items are data sets with the same encoding.
  DicomData& sequence(std::uint16_t group, std::uint16_t element, const std::vector<std::string>& items,
                      bool defined_length = false) {
    std::string value;
    for (const std::string& item : items)
      value += bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint32_t>(0xfffe, 0xe000,
                                                                             static_cast<std::uint32_t>(item.size())) +
               item;
    head(group, element, "SQ", defined_length ? static_cast<std::uint32_t>(value.size()) : 0xffffffffu);
    bytes += value;
    if (!defined_length) bytes += bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint32_t>(0xfffe, 0xe0dd, 0);
    return *this;
  }
  /// Adds compressed pixels: an empty table of offsets and these fragments.
  DicomData& fragments(std::vector<std::string> fragments) {
    fragments.insert(fragments.begin(), "");
    const std::size_t begin = bytes.size();
    sequence(0x7fe0, 0x0010, fragments);
    bytes.replace(begin + 4, 2, "OB");
    return *this;
  }

 private:
  void head(std::uint16_t group, std::uint16_t element, const std::string& vr, std::uint32_t length) {
    bytes += bytes_of_numbers(group, element);
    if (!explicit_vr) {
      bytes += bytes_of_numbers(length);
    } else if (vr == "SQ" || vr == "OB" || vr == "OW" || vr == "UN" || vr == "OF") {
      bytes.append(vr).append(bytes_of_numbers<std::uint16_t, std::uint32_t>(0, length));
    } else {
      bytes.append(vr).append(bytes_of_numbers(static_cast<std::uint16_t>(length)));
    }
  }
};

/// Returns a complete file: preamble, meta information, data set.
inline std::string dicom_file(const std::string& data, const std::string& sop_class,
                              const std::string& syntax = kExplicitLittle) {
  DicomData rest;
  rest.raw(0x0002, 0x0001, "OB", std::string("\0\1", 2));
  rest.text(0x0002, 0x0002, "UI", sop_class).text(0x0002, 0x0003, "UI", "1.2.3.4.5");
  rest.text(0x0002, 0x0010, "UI", syntax).text(0x0002, 0x0012, "UI", "1.2.3");
  DicomData meta;
  meta.raw(0x0002, 0x0000, "UL", bytes_of_numbers(static_cast<std::uint32_t>(rest.bytes.size())));
  std::string file(128, '\0');
  return file.append("DICM").append(meta.bytes).append(rest.bytes).append(data);
}

/// Adds the attributes of 16-bit pixels with `bits` stored bits.
inline DicomData& describe_pixels(DicomData& data, int columns, int rows, int frames, std::uint16_t bits = 16,
                                  const char* photometric = "MONOCHROME2") {
  data.us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", photometric);
  if (frames > 0) data.text(0x0028, 0x0008, "IS", std::to_string(frames));
  data.us(0x0028, 0x0010, static_cast<std::uint16_t>(rows)).us(0x0028, 0x0011, static_cast<std::uint16_t>(columns));
  data.us(0x0028, 0x0100, 16).us(0x0028, 0x0101, bits).us(0x0028, 0x0102, static_cast<std::uint16_t>(bits - 1));
  data.us(0x0028, 0x0103, 0);
  return data;
}

/// Frame of an enhanced multi-frame file; pixel (i, j) has the value value + 10 j + i.
struct EnhancedFrame {
  std::array<double, 3> position{};
  int value = 0;
  int time = 1;  ///< index of the second dimension
  double slope = 1, intercept = 0;
  std::array<double, 6> axes{1, 0, 0, 0, 1, 0};
  std::string stack = "1";
};

struct EnhancedFile {
  std::vector<EnhancedFrame> frames;
  int columns = 4, rows = 3;
  std::array<double, 2> between_rows_and_columns{0.5, 0.75};
  bool explicit_vr = true, defined_length = false, shared_axes = true, dimensions = true;

  std::string bytes() const {
    const auto one = [&](const std::function<void(DicomData&)>& f) {
      DicomData data{.explicit_vr = explicit_vr};
      f(data);
      return data.bytes;
    };
    const auto nested = [&](DicomData& to, std::uint16_t group, std::uint16_t element,
                            const std::function<void(DicomData&)>& f) {
      to.sequence(group, element, {one(f)}, defined_length);
    };
    const auto axes = [&](DicomData& to, const std::array<double, 6>& a) {
      nested(to, 0x0020, 0x9116, [&](DicomData& d) { d.numbers(0x0020, 0x0037, {a.begin(), a.end()}); });
    };
    std::vector<std::string> groups;
    std::string pixels;
    std::uint32_t number = 0;
    for (const EnhancedFrame& f : frames) {
      ++number;
      groups.push_back(one([&](DicomData& g) {
        nested(g, 0x0020, 0x9111, [&](DicomData& d) {
          d.text(0x0020, 0x9056, "SH", f.stack);
          if (dimensions) {
            d.raw(0x0020, 0x9128, "UL", bytes_of_numbers(static_cast<std::uint32_t>(f.time)));
            d.raw(0x0020, 0x9157, "UL", bytes_of_numbers(number, static_cast<std::uint32_t>(f.time)));
          }
        });
        nested(g, 0x0020, 0x9113, [&](DicomData& d) {
          d.numbers(0x0020, 0x0032, {f.position.begin(), f.position.end()});
        });
        if (!shared_axes) axes(g, f.axes);
        nested(g, 0x0028, 0x9145, [&](DicomData& d) {
          d.numbers(0x0028, 0x1052, {f.intercept}).numbers(0x0028, 0x1053, {f.slope}).text(0x0028, 0x1054, "LO", "US");
        });
      }));
      for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) pixels += bytes_of_numbers(static_cast<std::uint16_t>(f.value + 10 * j + i));
      }
    }
    const std::string shared = one([&](DicomData& g) {
      if (shared_axes) axes(g, frames.front().axes);
      nested(g, 0x0028, 0x9110, [&](DicomData& d) {
        d.numbers(0x0018, 0x0050, {9})
            .numbers(0x0028, 0x0030, {between_rows_and_columns[0], between_rows_and_columns[1]});
      });
    });
    DicomData data{.explicit_vr = explicit_vr};
    data.text(0x0008, 0x0016, "UI", kEnhancedMr).text(0x0008, 0x0018, "UI", "1.2.3.4.5");
    data.text(0x0008, 0x0060, "CS", "MR").text(0x0020, 0x000e, "UI", "1.2.3.4");
    if (dimensions) {
      const auto pointer = [&](std::uint16_t group, std::uint16_t element) {
        return one([&](DicomData& d) { d.raw(0x0020, 0x9165, "AT", bytes_of_numbers(group, element)); });
      };
      data.sequence(0x0020, 0x9222, {pointer(0x0020, 0x9057), pointer(0x0020, 0x9128)}, defined_length);
    }
    describe_pixels(data, columns, rows, static_cast<int>(frames.size()));
    data.sequence(0x5200, 0x9229, {shared}, defined_length).sequence(0x5200, 0x9230, groups, defined_length);
    data.raw(0x7fe0, 0x0010, "OW", pixels);
    return dicom_file(data.bytes, kEnhancedMr, explicit_vr ? kExplicitLittle : kImplicitLittle);
  }
};

}  // namespace simplexseg::test
