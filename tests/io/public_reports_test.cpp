// SPDX-License-Identifier: Apache-2.0
// Conditions of docs/results/public-reports.md that concern volumes.
#include <algorithm>
#include <tuple>

#include "dicom_files.h"
#include "io/labels/labels_io.h"
#include "structure_set.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

using test::bytes_of_numbers;
using test::DicomData;
using test::error_of;

class PublicReports : public test::FolderTest {
 protected:
  static bool has_warning(const LoadedVolume& loaded, const std::string& part) {
    return std::any_of(loaded.warnings.begin(), loaded.warnings.end(),
                       [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
  }
};

/// CT slice of 4 x 1 pixels with a Modality LUT. `table`: bytes of its entries.
std::string slice_with_table(std::uint16_t entries, std::int16_t begin, std::uint16_t bits, const std::string& table,
                             const std::array<std::int16_t, 4>& stored) {
  DicomData data;
  data.text(0x0008, 0x0060, "CS", "CT").text(0x0020, 0x000e, "UI", "1.2.3.4").numbers(0x0020, 0x0032, {0, 0, 0});
  data.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0}).us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2");
  data.us(0x0028, 0x0010, 1).us(0x0028, 0x0011, 4).numbers(0x0028, 0x0030, {1, 1});
  data.us(0x0028, 0x0100, 16).us(0x0028, 0x0101, 16).us(0x0028, 0x0102, 15).us(0x0028, 0x0103, 1);
  DicomData item;
  item.raw(0x0028, 0x3002, "US", bytes_of_numbers(entries, begin, bits)).raw(0x0028, 0x3006, "OW", table);
  data.sequence(0x0028, 0x3000, {item.bytes});
  data.raw(0x7fe0, 0x0010, "OW", bytes_of_numbers(stored[0], stored[1], stored[2], stored[3]));
  return test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.2");
}

TEST_F(PublicReports, ModalityLutsAreApplied) {
  const std::array<std::int16_t, 4> stored{-9, -2, 0, 99};
  const std::string words = bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint16_t>(1000, 40000, 60000);
  const Volume wide = read_volume(write("w.dcm", slice_with_table(3, -2, 16, words, stored)));
  const std::string bytes("\x05\xfe\x07\0", 4);
  const Volume narrow = read_volume(write("n.dcm", slice_with_table(3, -2, 8, bytes, stored)));
  const std::array<double, 4> expected{1000, 1000, 60000, 60000}, expected_narrow{5, 5, 7, 7};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(wide.value(i, 0, 0), expected[static_cast<std::size_t>(i)]) << i;
    EXPECT_EQ(narrow.value(i, 0, 0), expected_narrow[static_cast<std::size_t>(i)]) << i;
  }
  EXPECT_HAS(error_of([&] { read_volume(write("s.dcm", slice_with_table(9, 0, 16, words, stored))); }),
             "fewer entries");
}

/// Element in big-endian explicit encoding; `value` has the byte order of the file.
std::string big_endian(std::uint16_t group, std::uint16_t element, const std::string& vr, std::string value) {
  const auto two = [](std::size_t n) { return std::string{static_cast<char>(n >> 8), static_cast<char>(n & 0xff)}; };
  if (value.size() % 2) value += vr == "UI" ? '\0' : ' ';
  const std::string length = vr[0] == 'O' ? std::string(4, '\0') + two(value.size()) : two(value.size());
  return two(group) + two(element) + vr + length + value;
}

TEST_F(PublicReports, SmallPixelsInBigEndianWords) {
  const auto us = [](std::uint16_t element, char value) {
    return big_endian(0x0028, element, "US", std::string{'\0', value});
  };
  for (const std::string vr : {"OW", "OB"}) {
    const std::string pixels = vr == "OW" ? std::string("\x02\x01\x04\x03\x06\x05", 6) : std::string("\1\2\3\4\5\6", 6);
    const std::string data = big_endian(0x0008, 0x0060, "CS", "OT") + big_endian(0x0020, 0x000e, "UI", "1.2.3.4") +
                             big_endian(0x0020, 0x0032, "DS", "0\\0\\0") +
                             big_endian(0x0020, 0x0037, "DS", "1\\0\\0\\0\\1\\0") + us(0x0002, 1) +
                             big_endian(0x0028, 0x0004, "CS", "MONOCHROME2") + us(0x0010, 2) + us(0x0011, 3) +
                             big_endian(0x0028, 0x0030, "DS", "1\\1") + us(0x0100, 8) + us(0x0101, 8) + us(0x0102, 7) +
                             us(0x0103, 0) + big_endian(0x7fe0, 0x0010, vr, pixels);
    const Volume volume = read_volume(write(vr + ".dcm", test::dicom_file(data, "1.2", "1.2.840.10008.1.2.2")));
    for (int v = 0; v < 6; ++v) EXPECT_EQ(volume.value(v % 3, v / 3, 0), v + 1) << vr;
  }
}

TEST_F(PublicReports, TheBackgroundOfALabelMapIsNotALabel) {
  const auto one = [](const auto& fill) {
    DicomData data;
    fill(data);
    return data.bytes;
  };
  for (const bool by_code : {false, true}) {
    DicomData data;
    data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.66.7").text(0x0008, 0x0060, "CS", "SEG");
    data.text(0x0020, 0x000e, "UI", "1.2.3.4").us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2");
    data.text(0x0028, 0x0008, "IS", "1").us(0x0028, 0x0010, 1).us(0x0028, 0x0011, 4);
    data.us(0x0028, 0x0100, 8).us(0x0028, 0x0101, 8).us(0x0028, 0x0102, 7).us(0x0028, 0x0103, 0);
    if (!by_code) data.us(0x0028, 0x0120, 255);
    data.text(0x0062, 0x0001, "CS", "LABELMAP");
    const std::string code = one([](DicomData& d) {
      d.text(0x0008, 0x0100, "SH", "125040").text(0x0008, 0x0102, "SH", "DCM").text(0x0008, 0x0104, "LO", "Background");
    });
    const std::string background = one([&](DicomData& d) {
      d.us(0x0062, 0x0004, 255).text(0x0062, 0x0005, "LO", "outside");
      if (by_code) d.sequence(0x0062, 0x000f, {code});
    });
    const std::string liver = one([](DicomData& d) { d.us(0x0062, 0x0004, 1).text(0x0062, 0x0005, "LO", "liver"); });
    data.sequence(0x0062, 0x0002, {background, liver});
    const std::string plane = one([&](DicomData& d) {
      d.sequence(0x0020, 0x9113, {one([](DicomData& p) { p.numbers(0x0020, 0x0032, {0, 0, 0}); })});
      d.sequence(0x0020, 0x9116, {one([](DicomData& p) { p.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0}); })});
      d.sequence(0x0028, 0x9110, {one([](DicomData& p) {
                   p.numbers(0x0018, 0x0050, {1}).numbers(0x0028, 0x0030, {1, 1});
                 })});
    });
    data.sequence(0x5200, 0x9230, {plane}).raw(0x7fe0, 0x0010, "OB", std::string("\xff\x01\xff\x01", 4));
    const LoadedVolume loaded =
        load_volume(write("a.dcm", test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.66.7")));
    for (int i = 0; i < 4; ++i) EXPECT_EQ(loaded.volume.value(i, 0, 0), i % 2) << by_code;
    ASSERT_EQ(loaded.segments.size(), 1u);
    EXPECT_EQ(loaded.segments[0].name, "liver");
  }
}

TEST_F(PublicReports, LabelsOfAnotherFrameOfReference) {
  const auto image = [&](const std::string& frame) {
    DicomData data;
    data.text(0x0008, 0x0060, "CS", "MR").text(0x0020, 0x000e, "UI", "1.2.3.4").numbers(0x0020, 0x0032, {-4, -4, 0});
    data.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
    if (!frame.empty()) data.text(0x0020, 0x0052, "UI", frame);
    test::describe_pixels(data, 9, 9, 0);
    data.numbers(0x0028, 0x0030, {1, 1}).raw(0x7fe0, 0x0010, "OW", std::string(2 * 81, '\1'));
    return read_volume(write("image.dcm", test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.4")));
  };
  const auto structures = [&](const std::string& frame) {
    const test::Squares squares{.name = "a", .half_mm = 2.5, .z_mm = {0}, .frame_of_reference = frame};
    return write("rt.dcm", test::structure_set_of_squares(Eigen::Isometry3d::Identity(), {squares}));
  };
  for (const auto& [of_image, of_labels, expected] :
       {std::tuple("1.2.7", "1.2.7", false), {"1.2.7", "1.2.77", true}, {"", "1.2.77", false}, {"1.2.7", "", false}}) {
    std::vector<std::string> warnings;
    load_labels_onto(structures(of_labels), image(of_image).geometry(), "the image", warnings);
    const bool warned = std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("frame of reference") != std::string::npos;
    });
    EXPECT_EQ(warned, expected) << of_image << " and " << of_labels;
  }
}

TEST_F(PublicReports, UnitAndRescalingOfMetaImages) {
  const std::string header =
      "ObjectType = Image\nNDims = 3\nOffset = 10 20 30\nElementSpacing = 8 8 16\nDimSize = 2 1 1\n";
  const std::string voxels = bytes_of_numbers<std::int16_t, std::int16_t>(0, 100);
  const auto file = [&](const std::string& lines) {
    return header + lines + "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" + voxels;
  };
  const LoadedVolume um = load_volume(write("u.mha", file("DistanceUnits = um\n")));
  EXPECT_TRUE(um.volume.geometry().spacing_mm.isApprox(Eigen::Vector3d(0.008, 0.008, 0.016)));
  EXPECT_TRUE(um.volume.geometry().origin_mm.isApprox(Eigen::Vector3d(0.01, 0.02, 0.03)));
  EXPECT_TRUE(has_warning(um, "lengths are in um"));
  EXPECT_EQ(read_volume(write("m.mha", file("DistanceUnits = mm\n"))).geometry().spacing_mm[2], 16);
  EXPECT_EQ(read_volume(write("q.mha", file("DistanceUnits = ?\n"))).geometry().spacing_mm[2], 16);
  EXPECT_HAS(error_of([&] { read_volume(write("x.mha", file("DistanceUnits = parsec\n"))); }), "'parsec'");
  const LoadedVolume scaled = load_volume(
      write("s.mha", file("ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1000\n")));
  EXPECT_EQ(scaled.volume.value(0, 0, 0), -1000);
  EXPECT_EQ(scaled.volume.value(1, 0, 0), -800);
  EXPECT_TRUE(has_warning(scaled, "rescaled"));
}

TEST_F(PublicReports, VoxelSizesOfNrrdFilesFollowFromTheirAxisLimits) {
  const auto geometry = [&](const std::string& maxima, const std::string& centers) {
    const std::string text =
        "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 2\nencoding: raw\naxis mins: 0 0 0\naxis maxs: " + maxima +
        "\n" + centers + "\n" + std::string(24, '\1');
    const LoadedVolume loaded = load_volume(write("a.nrrd", text));
    EXPECT_FALSE(has_warning(loaded, "no voxel size"));
    return loaded.volume.geometry();
  };
  const Eigen::Vector3d size(2, 3, 4);
  EXPECT_TRUE(geometry("8 9 8", "").spacing_mm.isApprox(size));
  EXPECT_TRUE(geometry("8 9 8", "centers: cell cell cell\n").origin_mm.isApprox(size / 2));
  EXPECT_TRUE(geometry("6 6 4", "centers: node node node\n").spacing_mm.isApprox(size));
}

}  // namespace
}  // namespace simplexseg
