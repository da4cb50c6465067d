// SPDX-License-Identifier: Apache-2.0
// Single-frame DICOM slices for the tests.
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "dicom_files.h"

namespace simplexseg::test {

/// Slice of a CT series; pixel (i, j) has the value value + 10 j + i.
struct CtSlice {
  std::string series = "1.2.3.1", name = "chest";
  double z_mm = 0;
  int value = 100;
  std::uint16_t columns = 6, rows = 5;
  std::string patient = "Doe^Jane", character_set = "ISO_IR 100";
  bool sagittal = false;
  std::string study{};  ///< study UID; empty: attribute missing
  std::string echo{};   ///< echo time; empty: attribute missing

  std::string bytes() const {
    DicomData data;
    data.text(0x0008, 0x0005, "CS", character_set);
    data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2");
    data.text(0x0008, 0x0018, "UI", series + "." + std::to_string(static_cast<int>(1000 + 10 * z_mm)));
    data.text(0x0008, 0x0020, "DA", "20240531").text(0x0008, 0x0060, "CS", "CT");
    data.text(0x0008, 0x1030, "LO", "follow-up").text(0x0008, 0x103e, "LO", name);
    data.text(0x0010, 0x0010, "PN", patient).text(0x0010, 0x0020, "LO", "P-17");
    if (!echo.empty()) data.text(0x0018, 0x0081, "DS", echo);
    if (!study.empty()) data.text(0x0020, 0x000d, "UI", study);
    data.text(0x0020, 0x000e, "UI", series);
    data.numbers(0x0020, 0x0032, sagittal ? std::vector<double>{z_mm, 0, 0} : std::vector<double>{0, 0, z_mm});
    data.numbers(0x0020, 0x0037,
                 sagittal ? std::vector<double>{0, 1, 0, 0, 0, -1} : std::vector<double>{1, 0, 0, 0, 1, 0});
    data.us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2").us(0x0028, 0x0010, rows);
    data.us(0x0028, 0x0011, columns).numbers(0x0028, 0x0030, {0.5, 0.75});
    data.us(0x0028, 0x0100, 16).us(0x0028, 0x0101, 16).us(0x0028, 0x0102, 15).us(0x0028, 0x0103, 0);
    std::string pixels;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) pixels += bytes_of_numbers(static_cast<std::uint16_t>(value + 10 * j + i));
    data.raw(0x7fe0, 0x0010, "OW", pixels);
    return dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.2");
  }
  void write(const std::filesystem::path& path) const {
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes();
  }
};

/// Writes slices at 0, 2, 4 ... mm as FOLDER/NAME0, NAME1 ...
inline void write_series(const std::filesystem::path& folder, CtSlice slice, int count) {
  for (int n = 0; n < count; ++n) {
    slice.z_mm = 2.0 * n;
    slice.value = 100 + n;
    slice.write(folder / (slice.name + std::to_string(n)));
  }
}

/// Writes two volumes of three slices with the echo times `early` and `late` (ms) and the values 46 and 123 at voxel
/// (0, 0, 0).
inline void write_echoes(const std::filesystem::path& folder, const char* early = "4.6", const char* late = "12.3") {
  for (int n = 0; n < 6; ++n) {
    const bool first = n % 2 == 0;
    CtSlice slice{.z_mm = 2.0 * (n / 2), .value = first ? 46 : 123, .echo = first ? early : late};
    slice.write(folder / std::to_string(n));
  }
}

}  // namespace simplexseg::test
