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

/// Image of 2 x 1 pixels in which one text element is `value`.
std::string with_element(std::uint16_t group, std::uint16_t element, const std::string& value, int z = 0) {
  DicomData data;
  data.text(0x0008, 0x0060, "CS", "CT");
  const auto add = [&](std::uint16_t g, std::uint16_t e, const char* vr, const std::string& usual) {
    const bool is_changed = g == group && e == element;
    if (is_changed || !usual.empty()) data.text(g, e, vr, is_changed ? value : usual);
  };
  add(0x0018, 0x0050, "DS", "2");
  add(0x0018, 0x0081, "DS", "");
  add(0x0018, 0x0088, "DS", "");
  data.text(0x0020, 0x000e, "UI", "1.2.3.4");
  add(0x0020, 0x0032, "DS", "0\\0\\" + std::to_string(z));
  add(0x0020, 0x0037, "DS", "1\\0\\0\\0\\1\\0");
  data.us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2");
  add(0x0028, 0x0008, "IS", "");
  data.us(0x0028, 0x0010, 1).us(0x0028, 0x0011, 2);
  add(0x0028, 0x0030, "DS", "1\\1");
  data.us(0x0028, 0x0100, 16).us(0x0028, 0x0101, 16).us(0x0028, 0x0102, 15).us(0x0028, 0x0103, 0);
  add(0x0028, 0x1052, "DS", "-99.5");
  add(0x0028, 0x1053, "DS", "0.5");
  data.raw(0x7fe0, 0x0010, "OW", test::bytes_of_numbers<std::uint16_t, std::uint16_t>(10, 20));
  return test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.2");
}

TEST_F(DicomErrors, NumbersThatAreNotWholeAreNamed) {
  struct Case {
    std::uint16_t group, element;
    const char *value, *message;
  };
  const Case cases[] = {
      {0x0028, 0x1053, "0,5", "its Rescale Slope (0028,1053) is '0,5', which is not a number"},
      {0x0028, 0x1052, "-99,5", "its Rescale Intercept (0028,1052) is '-99,5', which is not a number"},
      {0x0028, 0x1052, "12 HU", "its Rescale Intercept (0028,1052) is '12 HU'"},
      {0x0028, 0x1053, "1.5\\2.5", "its Rescale Slope (0028,1053) has 2 values instead of 1"},
      {0x0028, 0x1052, "1\\2", "its Rescale Intercept (0028,1052) has 2 values instead of 1"},
      {0x0028, 0x1053, "nan", "its Rescale Slope (0028,1053) is 'nan'"},
      {0x0020, 0x0032, "0\\0\\1,5", "its Image Position (Patient) (0020,0032) is '0\\0\\1,5', which contains"},
      {0x0020, 0x0032, "0\\\\2", "its Image Position (Patient) (0020,0032) is"},
      {0x0020, 0x0032, "0\\2", "its Image Position (Patient) (0020,0032) has 2 values instead of 3"},
      {0x0020, 0x0037, "1\\0\\0", "its Image Orientation (Patient) (0020,0037) has 3 values instead of 6"},
      {0x0028, 0x0030, "0.5", "its Pixel Spacing (0028,0030) has 1 value instead of 2"},
      {0x0028, 0x0030, "0,5\\0,5", "its Pixel Spacing (0028,0030) is '0,5\\0,5'"},
      {0x0028, 0x0030, "-1\\1", "its Pixel Spacing (0028,0030) is '-1\\1', which is negative"},
      {0x0018, 0x0050, "2,5", "its Slice Thickness (0018,0050) is '2,5'"},
      {0x0018, 0x0088, "2.5mm", "its Spacing Between Slices (0018,0088) is '2.5mm'"},
      {0x0028, 0x0008, "1.5", "its Number of Frames (0028,0008) is '1.5', which is not an integer"},
  };
  for (const Case& c : cases) EXPECT_HAS(rejection(with_element(c.group, c.element, c.value)), c.message);
}

TEST_F(DicomErrors, PaddedNumbersAndOptionalTraitsAreAccepted) {
  const std::string slopes[] = {" 0.5 ", std::string("0.5\0", 4), "+5E-1", ".5"};
  for (const std::string& slope : slopes) {
    const Volume volume = read_volume(write("a.dcm", with_element(0x0028, 0x1053, slope)));
    EXPECT_EQ(volume.value(0, 0, 0), -94.5) << slope;
  }
  // An echo time has no influence on the values.
  EXPECT_EQ(read_volume(write("a.dcm", with_element(0x0018, 0x0081, "4,6"))).value(1, 0, 0), -89.5);
  // An empty value is a missing one.
  EXPECT_EQ(read_volume(write("a.dcm", with_element(0x0028, 0x1053, "  "))).value(0, 0, 0), -89.5);
}

TEST_F(DicomErrors, ElementsWithoutEffectAreReported) {
  const auto warnings = [&](std::uint16_t group, std::uint16_t element, const std::string& value) {
    std::string all;
    for (const std::string& line : load_volume(write("a.dcm", with_element(group, element, value))).warnings)
      all += line + "\n";
    return all;
  };
  EXPECT_HAS(warnings(0x0028, 0x1053, "0"), "its Rescale Slope (0028,1053) is 0 and is ignored");
  EXPECT_HAS(warnings(0x0028, 0x0030, "0\\0"), "its Pixel Spacing (0028,0030) is '0\\0' and is ignored");
  EXPECT_HAS(warnings(0x0020, 0x0037, "1\\0\\0\\1\\0\\0"), "its Image Orientation (Patient) (0020,0037) is");
}

TEST_F(DicomErrors, AnImageWithAnInvalidNumberIsNotOmitted) {
  for (int k = 0; k < 5; ++k) {
    const std::uint16_t group = k == 4 ? 0x0028 : 0;
    write(std::to_string(k) + ".dcm", with_element(group, 0x1053, "0,5", 2 * k));
  }
  EXPECT_HAS(error_of([&] { load_volume(folder); }),
             "its Rescale Slope (0028,1053) is '0,5', which is not a number: '4.dcm'");
}

TEST_F(DicomErrors, DecimalCommasOfTheReports) {
  const fs::path series = test::data_folder() / "reports/slopecomma";
  REQUIRE_DATA(series);
  const std::string message = error_of([&] { load_volume(series); });
  EXPECT_HAS(message, "its Rescale ");
  EXPECT_HAS(message, ",5', which is not a number");
  EXPECT_HAS(error_of([&] { load_volume(series / "0001.dcm"); }), "which is not a number");
}

TEST_F(DicomErrors, OtherFilesWithTheExtensionOfMinc) {
  EXPECT_HAS(error_of([&] { load_volume(write("a.mnc", "hello")); }), "not a readable MINC file");
}

}  // namespace
}  // namespace simplexseg
