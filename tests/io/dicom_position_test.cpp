// SPDX-License-Identifier: Apache-2.0
// Positions of DICOM slices relative to their spacing, and passes (acquisitions) of one series.
#include "io/dicom/dicom_position.h"

#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::DicomData;
using test::error_of;

/// CT slice of 2 x 2 pixels, all of the value `value`.
struct Slice {
  double z_mm = 0, pixel_mm = 1, thickness_mm = 0;
  std::uint16_t value = 0;
  int acquisition = 0, instance = 0;
  std::string echo_time{};

  std::string bytes() const {
    DicomData data;
    data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.2");
    data.text(0x0008, 0x0018, "UI", "1.2.3.4." + std::to_string(value)).text(0x0008, 0x0060, "CS", "CT");
    if (thickness_mm > 0) data.numbers(0x0018, 0x0050, {thickness_mm});
    if (!echo_time.empty()) data.text(0x0018, 0x0081, "DS", echo_time);
    data.text(0x0020, 0x000e, "UI", "1.2.3.4");
    if (acquisition > 0) data.text(0x0020, 0x0012, "IS", std::to_string(acquisition));
    if (instance > 0) data.text(0x0020, 0x0013, "IS", std::to_string(instance));
    data.numbers(0x0020, 0x0032, {0, 0, z_mm}).numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
    test::describe_pixels(data, 2, 2, 0);
    data.numbers(0x0028, 0x0030, {pixel_mm, pixel_mm});
    data.raw(0x7fe0, 0x0010, "OW", test::bytes_of_numbers(value, value, value, value));
    return test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.2");
  }
};

class DicomPosition : public test::FolderTest {
 protected:
  void add(const Slice& slice) { write("s" + std::to_string(count_++) + ".dcm", slice.bytes()); }

  int count_ = 10;
};

TEST_F(DicomPosition, TolerancesFollowTheSpacing) {
  EXPECT_DOUBLE_EQ(same_position_mm(1, 0), 0.01);
  EXPECT_DOUBLE_EQ(same_position_mm(0.008, 0), 8e-5);
  EXPECT_DOUBLE_EQ(same_position_mm(100, 1000), 1);
  EXPECT_NEAR(same_position_mm(0.008, 1000), 1.2e-4, 1e-5);  // single precision at 1 m
  EXPECT_DOUBLE_EQ(same_position_mm(0.0001, 1000), 1e-5);
  EXPECT_NEAR(same_position_mm(0, 100), 1.2e-5, 1e-6);
}

TEST_F(DicomPosition, GridsOfAnySpacingAreRead) {
  for (const double spacing : {0.0005, 0.008, 0.5, 100.0}) {
    count_ = 10;
    for (int k = 0; k < 5; ++k)
      add({.z_mm = 20 + spacing * k, .pixel_mm = spacing, .thickness_mm = spacing, .value = std::uint16_t(k)});
    const LoadedVolume loaded = load_volume(folder);
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
    EXPECT_EQ(loaded.volume.geometry().size[2], 5);
    EXPECT_NEAR(loaded.volume.geometry().spacing_mm[2], spacing, 1e-4 * spacing);
    for (int k = 0; k < 5; ++k) EXPECT_EQ(loaded.volume.value(0, 0, k), k);
  }
}

TEST_F(DicomPosition, EchoesOfACoarseGridMayDifferByRounding) {
  for (int k = 0; k < 3; ++k) {
    add({.z_mm = 100.0 * k, .pixel_mm = 100, .value = std::uint16_t(k), .echo_time = "12.3"});
    add({.z_mm = 100.0 * k + 0.05, .pixel_mm = 100, .value = std::uint16_t(10 + k), .echo_time = "4.60"});
  }
  const LoadedVolume first = load_volume(folder);
  EXPECT_EQ(first.volume.geometry().size[2], 3);
  EXPECT_EQ(first.volume.value(0, 0, 1), 11);  // echo time 4.6 before 12.3
  EXPECT_EQ(load_volume(folder, 2).volume.value(0, 0, 1), 1);
}

TEST_F(DicomPosition, PassesOverDifferentPositionsAreVolumes) {
  std::uint16_t value = 0;
  for (int k = 0; k < 5; ++k) add({.z_mm = 2.0 * k, .value = value++, .acquisition = 1, .instance = k + 1});
  for (int k = 0; k < 4; ++k) add({.z_mm = 12.0 + 2 * k, .value = value++, .acquisition = 2, .instance = k + 6});
  const LoadedVolume first = load_volume(folder), second = load_volume(folder, 2);
  EXPECT_EQ(first.frames, 2);
  EXPECT_EQ(first.volume.geometry().size[2], 5);
  EXPECT_EQ(second.volume.geometry().size[2], 4);
  EXPECT_EQ(second.volume.geometry().origin_mm.z(), 12);
  EXPECT_EQ(second.volume.value(0, 0, 0), 5);
  EXPECT_HAS(first.warnings.at(1), "2 passes over different positions (acquisition number 1: 5 slices");
}

TEST_F(DicomPosition, OverlappingPassesAreVolumes) {
  std::uint16_t value = 0;
  for (int k = 0; k < 5; ++k) add({.z_mm = 2.0 * k, .value = value++, .acquisition = 1});
  for (int k = 0; k < 6; ++k) add({.z_mm = 4 + 2.0 * k, .value = value++, .acquisition = 2});
  EXPECT_EQ(load_volume(folder).volume.geometry().size[2], 5);
  EXPECT_EQ(load_volume(folder, 2).volume.geometry().size[2], 6);
}

TEST_F(DicomPosition, LostSlicesBetweenAcquisitionsStayMissing) {
  std::uint16_t value = 0;
  for (int k = 0; k < 5; ++k) add({.z_mm = 2.0 * k, .value = value++, .acquisition = 1, .instance = k + 1});
  for (int k = 6; k < 10; ++k) add({.z_mm = 2.0 * k, .value = value++, .acquisition = 2, .instance = k + 1});
  EXPECT_HAS(error_of([&] { load_volume(folder); }), "1 missing slice (");
  // Contiguous acquisitions are one volume.
  add({.z_mm = 10, .value = value++, .acquisition = 1, .instance = 6});
  EXPECT_EQ(load_volume(folder).volume.geometry().size[2], 10);
}

TEST_F(DicomPosition, MicroCtOfTheReports) {
  const fs::path micro = test::data_folder() / "reports/micro8";
  REQUIRE_DATA(micro);
  const LoadedVolume loaded = load_volume(micro);
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
  EXPECT_EQ(loaded.volume.geometry().size, (std::array<int, 3>{16, 16, 8}));
  EXPECT_TRUE(loaded.volume.geometry().spacing_mm.isApprox(Eigen::Vector3d::Constant(0.008), 1e-6));
}

}  // namespace
}  // namespace simplexseg
