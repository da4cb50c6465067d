// SPDX-License-Identifier: Apache-2.0
// Interpretation of stored DICOM pixels: doses, segments, MONOCHROME1, mosaics.
#include <algorithm>
#include <utility>

#include "dicom_files.h"
#include "io/labels/labels_io.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using test::bytes_of_numbers;
using test::DicomData;
using test::error_of;

class DicomValues : public test::FolderTest {};

DicomData slice(const std::string& modality, const std::string& image_type = "ORIGINAL\\PRIMARY") {
  DicomData data;
  data.text(0x0008, 0x0008, "CS", image_type).text(0x0008, 0x0060, "CS", modality);
  data.text(0x0020, 0x000e, "UI", "1.2.3.4").numbers(0x0020, 0x0032, {-1, -2, -3});
  return data.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
}

TEST_F(DicomValues, InvertedImagesKeepTheirValues) {
  DicomData data = slice("CR");
  test::describe_pixels(data, 2, 1, 0, 12, "MONOCHROME1");
  data.numbers(0x0028, 0x1052, {200}).numbers(0x0028, 0x1053, {0.5});
  data.raw(0x7fe0, 0x0010, "OW", bytes_of_numbers<std::uint16_t, std::uint16_t>(1000, 0xf004));  // overlay bits
  const LoadedVolume loaded = load_volume(write("a.dcm", test::dicom_file(data.bytes, "1.2")));
  EXPECT_EQ(loaded.volume.value(0, 0, 0), 700);
  EXPECT_EQ(loaded.volume.value(1, 0, 0), 202);
  EXPECT_TRUE(loaded.low_is_bright);
  EXPECT_EQ(loaded.intensity_unit, "");
  EXPECT_EQ(std::count_if(loaded.warnings.begin(), loaded.warnings.end(),
                          [](const std::string& w) { return w.find("MONOCHROME1") == 0; }),
            1);
}

/// 16 stored bits with intercept -1024: the volume has 16 bits unless a value does not fit.
TEST_F(DicomValues, Shifted16BitValuesAreKeptIn16BitsWhereTheyFit) {
  const auto write_slices = [&](std::uint16_t odd) {
    for (std::uint16_t k = 0; k < 3; ++k) {
      DicomData data;
      data.text(0x0008, 0x0018, "UI", "1.2.3." + std::to_string(k + 1)).text(0x0008, 0x0060, "CS", "CT");
      data.text(0x0020, 0x000e, "UI", "1.2.3.4").numbers(0x0020, 0x0032, {0, 0, 2.0 * k});
      data.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
      test::describe_pixels(data, 2, 1, 0);
      data.numbers(0x0028, 0x0030, {1, 1}).numbers(0x0028, 0x1052, {-1024}).numbers(0x0028, 0x1053, {1});
      data.raw(0x7fe0, 0x0010, "OW", bytes_of_numbers(k, k == 1 ? odd : static_cast<std::uint16_t>(33791)));
      write("ct/" + std::to_string(k), test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.2"));
    }
    return read_volume(folder / "ct");
  };
  fs::create_directory(folder / "ct");
  for (const std::uint16_t odd : {std::uint16_t{500}, std::uint16_t{65535}}) {
    const Volume volume = write_slices(odd);
    EXPECT_EQ(volume.type(), odd == 500 ? VoxelType::Int16 : VoxelType::Int32);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(volume.value(0, 0, k), k - 1024);
      EXPECT_EQ(volume.value(1, 0, k), k == 1 ? odd - 1024 : 32767);
    }
  }
  EXPECT_EQ(load_volume(folder / "ct").intensity_unit, "HU");
}

std::string dose(const std::vector<double>& offsets, const std::vector<double>& axes = {1, 0, 0, 0, 1, 0}) {
  DicomData data;
  data.text(0x0008, 0x0060, "CS", "RTDOSE").text(0x0020, 0x000e, "UI", "1.2.3.4");
  data.numbers(0x0020, 0x0032, {-1, -2, 30}).numbers(0x0020, 0x0037, axes);
  test::describe_pixels(data, 2, 1, 3);
  data.numbers(0x0028, 0x0030, {2, 3}).numbers(0x3004, 0x000c, offsets).text(0x3004, 0x000e, "DS", "0.25");
  data.raw(0x7fe0, 0x0010, "OW",
           bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint16_t, std::uint16_t, std::uint16_t, std::uint16_t>(
               10, 11, 20, 21, 30, 31));
  return test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.481.2");
}

TEST_F(DicomValues, DosesAreScaledAndPlacedByTheirOffsets) {
  for (const std::vector<double>& offsets : {std::vector<double>{0, 5, 10}, {30, 35, 40}}) {
    const LoadedVolume loaded = load_volume(write("a.dcm", dose(offsets)));
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
    const VolumeGeometry& g = loaded.volume.geometry();
    EXPECT_EQ(g.size, (std::array<int, 3>{2, 1, 3}));
    EXPECT_TRUE(g.spacing_mm.isApprox(Vector3d(3, 2, 5)));
    EXPECT_TRUE(g.origin_mm.isApprox(Vector3d(-1, -2, 30)));
    EXPECT_EQ(loaded.volume.value(1, 0, 2), 31 * 0.25);
  }
  // Decreasing offsets: the slices are reversed, each dose keeps its position.
  const Volume down = read_volume(write("b.dcm", dose({0, -5, -10})));
  const Vector3d at = down.geometry().index_from_world() * Vector3d(2, -2, 20);
  EXPECT_EQ(down.value(int(std::lround(at[0])), int(std::lround(at[1])), int(std::lround(at[2]))), 31 * 0.25);
  EXPECT_HAS(error_of([&] { load_volume(write("c.dcm", dose({0, 5, 15}))); }), "1 missing");
}

TEST_F(DicomValues, BigEndianPixelsOf32BitsAreRead) {
  const fs::path bad = test::data_folder() / "bad_input";
  REQUIRE_DATA(bad);
  const Volume little = read_volume(bad / "pydicom__rtdose.dcm"), big = read_volume(bad / "pydicom__rtdose_expb.dcm");
  EXPECT_TRUE(test::same_voxels(little, big));
  EXPECT_TRUE(little.geometry().same_grid(big.geometry()));
}

TEST_F(DicomValues, MosaicsAreRejected) {
  DicomData data = slice("MR", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC");
  test::describe_pixels(data, 2, 1, 0);
  data.raw(0x7fe0, 0x0010, "OW", "abcd");
  const fs::path path = write("a.dcm", test::dicom_file(data.bytes, test::kEnhancedMr));
  for (const fs::path& named : {path, folder}) {
    const std::string message = error_of([&] { load_volume(named); });
    EXPECT_HAS(message, "Siemens mosaic");
    EXPECT_HAS(message, "convert it to NIfTI");
    EXPECT_EQ(error_of([&] { read_volume_info(named); }), message);
  }
}

struct SegmentFrame {
  double z;
  std::uint16_t segment;
  std::array<int, 12> values;  ///< 4 x 3 pixels
};

std::string segmentation(const std::string& type, const std::vector<SegmentFrame>& frames, double between = 0,
                         double thickness = 0) {
  std::vector<std::string> groups;
  std::string pixels;
  std::vector<int> bits;
  for (const SegmentFrame& f : frames) {
    DicomData position, segment, group;
    position.numbers(0x0020, 0x0032, {5, 6, f.z});
    segment.us(0x0062, 0x000b, f.segment);
    group.sequence(0x0020, 0x9113, {position.bytes});
    if (f.segment > 0) group.sequence(0x0062, 0x000a, {segment.bytes});
    groups.push_back(group.bytes);
    for (const int value : f.values) type == "BINARY" ? bits.push_back(value) : pixels.push_back(char(value));
  }
  if (!bits.empty()) pixels.resize((bits.size() + 7) / 8);
  for (std::size_t i = 0; i < bits.size(); ++i) pixels[i / 8] = char(pixels[i / 8] | (bits[i] << (i % 8)));
  DicomData axes, measures, shared, data;
  axes.numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
  if (thickness > 0) measures.numbers(0x0018, 0x0050, {thickness});
  if (between > 0) measures.numbers(0x0018, 0x0088, {between});
  measures.numbers(0x0028, 0x0030, {2, 3});
  shared.sequence(0x0020, 0x9116, {axes.bytes}).sequence(0x0028, 0x9110, {measures.bytes});
  data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.66.4").text(0x0008, 0x0060, "CS", "SEG");
  data.text(0x0020, 0x000e, "UI", "1.2.3.4").us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2");
  data.text(0x0028, 0x0008, "IS", std::to_string(frames.size())).us(0x0028, 0x0010, 3).us(0x0028, 0x0011, 4);
  const std::uint16_t size = type == "BINARY" ? 1 : 8;
  data.us(0x0028, 0x0100, size).us(0x0028, 0x0101, size).us(0x0028, 0x0102, std::uint16_t(size - 1));
  data.us(0x0028, 0x0103, 0).text(0x0062, 0x0001, "CS", type);
  DicomData liver;  // red in CIELab
  liver.us(0x0062, 0x0004, 2).text(0x0062, 0x0005, "LO", "liver");
  liver.raw(0x0062, 0x000d, "US", bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint16_t>(35579, 53661, 50857));
  data.sequence(0x0062, 0x0002, {liver.bytes});
  if (type == "FRACTIONAL") data.us(0x0062, 0x000e, 200);
  data.sequence(0x5200, 0x9229, {shared.bytes}).sequence(0x5200, 0x9230, groups);
  data.raw(0x7fe0, 0x0010, "OB", pixels);
  return test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.66.4");
}

TEST_F(DicomValues, SegmentsBecomeLabelsAtThePositionsOfTheirFrames) {
  const std::array<int, 12> a{1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1}, b{0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1};
  // Segment 2 before 1, frames unsorted, none at z = 14, both segments at z = 10, where the higher number wins.
  const std::string bytes = segmentation("BINARY", {{12, 2, b}, {10, 1, a}, {16, 1, b}, {10, 2, b}, {12, 1, a}}, 2);
  const LoadedVolume loaded = load_volume(write("a.dcm", bytes));
  EXPECT_EQ(loaded.format, "DICOM SEG");
  EXPECT_EQ(loaded.volume.type(), VoxelType::UInt8);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_EQ(loaded.warnings[0],
            "4 voxels belong to several segments and are assigned to the one with the highest number");
  ASSERT_EQ(loaded.segments.size(), 1u);
  EXPECT_EQ(loaded.segments[0].value, 2);
  EXPECT_EQ(loaded.segments[0].name, "liver");
  const Colour red = loaded.segments[0].colour;
  EXPECT_TRUE(red.red > 250 && red.green < 10 && red.blue < 10) << int(red.red) << " " << int(red.green);
  const VolumeGeometry& g = loaded.volume.geometry();
  EXPECT_EQ(g.size, (std::array<int, 3>{4, 3, 4}));
  EXPECT_TRUE(g.origin_mm.isApprox(Vector3d(5, 6, 10)));
  EXPECT_TRUE(g.spacing_mm.isApprox(Vector3d(3, 2, 2)));
  for (int k = 0; k < 4; ++k) {
    for (int v = 0; v < 12; ++v) {
      const int both = b[std::size_t(v)] ? 2 : a[std::size_t(v)];
      const int expected = k < 2 ? both : k == 2 ? 0 : b[std::size_t(v)];
      EXPECT_EQ(loaded.volume.value(v % 4, v / 4, k), expected) << v << " " << k;
    }
  }
}

TEST_F(DicomValues, AnOverlappedSegmentIsReadAlone) {
  const std::array<int, 12> a{1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1}, b{0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1};
  LabelFile file(write("a.dcm", segmentation("BINARY", {{10, 1, a}, {10, 2, b}, {12, 2, b}, {12, 1, a}}, 2)));
  EXPECT_TRUE(file.reads_alone());
  const LoadedLabels alone = file.read({.label = 1});
  for (int k = 0; k < 2; ++k)
    for (int v = 0; v < 12; ++v) EXPECT_EQ(alone.volume.value(v % 4, v / 4, k), a[std::size_t(v)]) << v << " " << k;
  for (const std::string& warning : alone.warnings) EXPECT_EQ(warning.find("several segments"), std::string::npos);
  const std::vector<LabelCount> counts = file.count();
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(counts[0].voxels, 8u);
  EXPECT_EQ(counts[1].voxels, 8u);
  EXPECT_HAS(error_of([&] { file.read({.label = 3}); }), "has no label 3: its labels are 2 (liver)");
  LabelFile apart(write("b.dcm", segmentation("BINARY", {{10, 1, a}, {12, 2, b}}, 2)));
  EXPECT_FALSE(apart.reads_alone());
}

TEST_F(DicomValues, SlicesWithoutFramesFollowTheStatedDistanceOrTheGaps) {
  const std::array<int, 12> a{1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  const auto loaded = [&](const std::vector<double>& positions, double between, double thickness) {
    std::vector<SegmentFrame> frames;
    for (const double z : positions) frames.push_back({z, 1, a});
    return load_volume(write("a.dcm", segmentation("BINARY", frames, between, thickness)));
  };
  const auto grid = [&](const std::vector<double>& positions, double between, double thickness) {
    const VolumeGeometry g = loaded(positions, between, thickness).volume.geometry();
    return std::pair(g.size[2], g.spacing_mm[2]);
  };
  EXPECT_EQ(grid({-14, -11, -7}, 0, 1), std::pair(8, 1.0)) << "no slice distance";
  EXPECT_EQ(grid({-14, -11, -7}, 0, 0), std::pair(8, 1.0)) << "neither distance nor thickness";
  EXPECT_EQ(grid({0, 2, 6}, 0, 1), std::pair(7, 1.0)) << "slices of 1 mm without gaps between them";
  EXPECT_EQ(grid({0, 2, 6}, 0, 5), std::pair(4, 2.0)) << "thick slices that overlap";
  EXPECT_EQ(grid({0, 2, 6}, 2, 1), std::pair(4, 2.0)) << "the stated distance";
  EXPECT_EQ(grid({0, 2, 4}, 0, 1), std::pair(3, 2.0)) << "evenly spaced";
  EXPECT_EQ(grid({0, 5, 12.5}, 0, 0), std::pair(6, 2.5));
  const LoadedVolume thin = loaded({0, 2, 4}, 0, 1);
  ASSERT_EQ(thin.warnings.size(), 1u);
  EXPECT_HAS(thin.warnings[0], "2 mm between the frames is used, although the slices are 1 mm thick");
}

TEST_F(DicomValues, ReportedSegmentationsAreWhole) {
  const fs::path reports = test::data_folder() / "reports";
  REQUIRE_DATA(reports);
  const LoadedLabels liver = load_labels(reports / "seg_over.dcm", {.name = "Liver"});
  EXPECT_NEAR(count_labels(liver.volume, liver.segments).at(0).millilitres, 6.34, 0.005);
  EXPECT_HAS(load_labels(reports / "seg_over.dcm").warnings.back(), "voxels belong to several segments");
  EXPECT_EQ(read_volume(reports / "seg_sparse.dcm").geometry().spacing_mm[2], 1);
}

TEST_F(DicomValues, FractionalSegmentsAndLabelMaps) {
  const std::array<int, 12> values{0, 99, 100, 200, 7, 0, 0, 0, 0, 0, 0, 255};
  const Volume half =
      read_volume(write("f.dcm", segmentation("FRACTIONAL", {{0, 3, values}, {1, 3, values}, {2, 3, values}})));
  for (int v = 0; v < 12; ++v) EXPECT_EQ(half.value(v % 4, v / 4, 1), values[std::size_t(v)] >= 100 ? 3 : 0);
  const Volume map =
      read_volume(write("l.dcm", segmentation("LABELMAP", {{0, 0, values}, {1, 0, {}}, {2, 0, values}})));
  for (int v = 0; v < 12; ++v) {
    EXPECT_EQ(map.value(v % 4, v / 4, 0), values[std::size_t(v)]);
    EXPECT_EQ(map.value(v % 4, v / 4, 1), 0);
  }
}

}  // namespace
}  // namespace simplexseg
