// SPDX-License-Identifier: Apache-2.0
// Unreadable DICOM files give the correct reason; time series are not mistaken for duplicates.
#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::DicomData;
using test::error_of;

class DicomErrors : public test::FolderTest {
 protected:
  std::string rejection(const std::string& bytes) {
    const fs::path path = write("a.dcm", bytes);
    const std::string message = error_of([&] { load_volume(path); });
    EXPECT_EQ(error_of([&] { read_volume_info(path); }), message);
    return message;
  }
};

/// Returns a slice of 2 x 1 pixels, `value` and value + 1.
std::string slice(double z, std::uint16_t value, const std::function<void(DicomData&)>& more = {},
                  const std::string& syntax = test::kExplicitLittle) {
  DicomData data;
  data.text(0x0008, 0x0060, "CS", "MR");
  if (more) more(data);
  data.text(0x0020, 0x000e, "UI", "1.2.3.4").numbers(0x0020, 0x0032, {0, 0, z});
  data.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
  test::describe_pixels(data, 2, 1, 0);
  data.numbers(0x0028, 0x0030, {1, 1});
  const auto second = static_cast<std::uint16_t>(value + 1);
  data.raw(0x7fe0, 0x0010, "OW", test::bytes_of_numbers(value, second));
  return test::dicom_file(data.bytes, "1.2", syntax);
}

TEST_F(DicomErrors, TimeSeriesAreNotDuplicates) {
  for (const std::uint16_t element : {0x0081, 0x1060}) {  // echo time, trigger time
    for (int k = 0; k < 4; ++k) {
      for (int time = 0; time < 3; ++time) {
        write("slice" + std::to_string(7 * k + time), slice(2 * k, std::uint16_t(100 * time + k), [&](DicomData& data) {
                data.text(0x0018, element, "DS", std::to_string(9 + 3 * time));
              }));
      }
    }
    for (int time = 0; time < 3; ++time) {
      const LoadedVolume loaded = load_volume(folder, time + 1);
      for (int k = 0; k < 4; ++k) EXPECT_EQ(loaded.volume.value(1, 0, k), 100 * time + k + 1);
      ASSERT_EQ(loaded.warnings.size(), 1u);
      EXPECT_HAS(loaded.warnings[0], "volume " + std::to_string(time + 1) + " of 3");
      EXPECT_HAS(loaded.warnings[0], std::to_string(9 + 3 * time) + ")");
    }
  }
}

TEST_F(DicomErrors, ObjectsWithoutAnImageAreNamed) {
  DicomData data;
  data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.481.3").text(0x0008, 0x0060, "CS", "RTSTRUCT");
  const std::string message = rejection(test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.481.3"));
  EXPECT_HAS(message, "contains no image (RT Structure Set Storage)");
  EXPECT_HAS(rejection(data.bytes), "contains no image (RT Structure Set Storage)");  // without a preamble
}

TEST_F(DicomErrors, UnsupportedTransferSyntaxesAreNamed) {
  EXPECT_HAS(rejection(slice(0, 1, {}, "1.2.840.10008.1.2.4.102")), "it is a video");
  EXPECT_HAS(rejection(slice(0, 1, {}, "1.2.840.10008.1.2.4.201")),
             "transfer syntax 1.2.840.10008.1.2.4.201 is not supported");
  EXPECT_HAS(rejection(slice(0, 1, {}, "1.2.3.99")), "transfer syntax 1.2.3.99 is not supported");
  EXPECT_HAS(error_of([&] { load_volume(folder); }), "(its transfer syntax 1.2.3.99 is not supported): 'a.dcm'");
  write("b.dcm", slice(0, 1));
  EXPECT_HAS(load_volume(folder).warnings.back(), "skipped (its transfer syntax 1.2.3.99");
}

TEST_F(DicomErrors, DamagedPixelsAreReported) {
  std::string bytes = slice(0, 1, {}, "1.2.840.10008.1.2.4.90");
  const std::size_t at = bytes.find(std::string("\xe0\x7f\x10\x00", 4));
  bytes.resize(at);
  const std::string fragment(100, '\7');
  bytes += std::string("\xe0\x7f\x10\x00OB\0\0\xff\xff\xff\xff\xfe\xff\x00\xe0\0\0\0\0\xfe\xff\x00\xe0", 24);
  bytes += test::bytes_of_numbers(std::uint32_t(100)) + fragment + std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  const fs::path path = write("a.dcm", bytes);
  EXPECT_HAS(error_of([&] { load_volume(path); }), "damaged");
}

TEST_F(DicomErrors, OtherFilesWithTheExtensionOfMinc) {
  EXPECT_HAS(error_of([&] { load_volume(write("a.mnc", "hello")); }), "not a readable MINC file");
}

}  // namespace
}  // namespace simplexseg
