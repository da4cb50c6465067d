// SPDX-License-Identifier: Apache-2.0
// Multi-frame files: position, rescaling and volume of each frame from its functional groups.
#include <algorithm>

#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using test::EnhancedFile;
using test::EnhancedFrame;
using test::error_of;

class EnhancedDicom : public test::FolderTest {
 protected:
  fs::path write_file(const EnhancedFile& file, const std::string& name = "a.dcm") { return write(name, file.bytes()); }
  LoadedVolume load(const EnhancedFile& file, int volume = 1) { return load_volume(write_file(file), volume); }
  std::string rejection(const EnhancedFile& file) {
    const fs::path path = write_file(file);
    const std::string message = error_of([&] { load_volume(path); });
    EXPECT_EQ(error_of([&] { read_volume_info(path); }), message);
    return message;
  }
};

/// Axes rotated about x, y and z; the first is the direction of i.
const Eigen::Matrix3d kTurn = (Eigen::AngleAxisd(0.4, Vector3d::UnitX()) * Eigen::AngleAxisd(-1.1, Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(0.7, Vector3d::UnitY()))
                                  .toRotationMatrix();
const Vector3d kFirst(-12.5, 33.25, 101.75);

/// Returns slices 2.5 mm apart along the normal, shifted by `shift` mm per slice along the second axis, with values
/// 100, 200 ...
EnhancedFile turned(int count, double shift = 0) {
  EnhancedFile file;
  for (int k = 0; k < count; ++k) {
    EnhancedFrame frame;
    const Vector3d at = kFirst + k * (2.5 * kTurn.col(2) + shift * kTurn.col(1));
    frame.position = {at.x(), at.y(), at.z()};
    frame.axes = {kTurn(0, 0), kTurn(1, 0), kTurn(2, 0), kTurn(0, 1), kTurn(1, 1), kTurn(2, 1)};
    frame.value = 100 * (k + 1);
    file.frames.push_back(frame);
  }
  return file;
}

/// Expects the voxels of turned() at their positions in space.
void expect_turned(const Volume& volume, int count, double shift = 0, double slope = 1) {
  ASSERT_EQ(volume.geometry().size, (std::array<int, 3>{4, 3, count}));
  const Eigen::Affine3d index = volume.geometry().index_from_world();
  for (int k = 0; k < count; ++k) {
    const Vector3d at = kFirst + k * (2.5 * kTurn.col(2) + shift * kTurn.col(1));
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 4; ++i) {
        const Vector3d voxel = index * (at + 0.75 * i * kTurn.col(0) + 0.5 * j * kTurn.col(1));
        const Vector3d whole = voxel.array().round();
        ASSERT_LT((voxel - whole).norm(), 1e-4);
        EXPECT_NEAR(volume.value(int(whole[0]), int(whole[1]), int(whole[2])), slope * (100 * (k + 1) + 10 * j + i),
                    1e-3);
      }
    }
  }
}

TEST_F(EnhancedDicom, FramesAreAtThePositionsOfTheirFunctionalGroups) {
  for (const bool explicit_vr : {true, false}) {
    for (const bool defined_length : {true, false}) {
      for (const bool shared_axes : {true, false}) {
        EnhancedFile file = turned(5);
        file.explicit_vr = explicit_vr, file.defined_length = defined_length, file.shared_axes = shared_axes;
        const LoadedVolume loaded = load(file);
        EXPECT_EQ(loaded.volume.type(), VoxelType::UInt16);
        EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
        expect_turned(loaded.volume, 5);
        EXPECT_TRUE(loaded.volume.geometry().spacing_mm.isApprox(Vector3d(0.75, 0.5, 2.5), 1e-6));
      }
    }
  }
}

TEST_F(EnhancedDicom, ShuffledAndReversedFramesAreSortedByPosition) {
  EnhancedFile file = turned(6);
  std::reverse(file.frames.begin(), file.frames.end());
  expect_turned(load(file).volume, 6);
  std::shuffle(file.frames.begin(), file.frames.end(), std::mt19937(3));
  expect_turned(load(file).volume, 6);
  expect_turned(read_volume(folder), 6);  // the same file as a series
}

TEST_F(EnhancedDicom, ATiltBecomesAShearedGrid) {
  const LoadedVolume loaded = load(turned(5, 0.8));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_HAS(loaded.warnings[0], "tilted gantry");
  expect_turned(loaded.volume, 5, 0.8);
}

TEST_F(EnhancedDicom, MissingDuplicateAndMixedFramesAreReportedByNumber) {
  EnhancedFile file = turned(6);
  file.frames.erase(file.frames.begin() + 3);
  std::string message = rejection(file);
  EXPECT_HAS(message, "1 missing");
  EXPECT_HAS(message, "frame 3 of 'a.dcm' and frame 4 of 'a.dcm'");
  file = turned(6);
  file.frames.push_back(file.frames[2]);
  message = rejection(file);
  EXPECT_HAS(message, "1 duplicate");
  EXPECT_HAS(message, "frame 3 of 'a.dcm' and frame 7 of 'a.dcm'");
  file = turned(6);
  file.shared_axes = false;
  file.frames[4].axes = {1, 0, 0, 0, 0, -1};
  EXPECT_HAS(rejection(file), "orientations: frame 5 of 'a.dcm'");
  file = turned(6);
  for (std::size_t axis = 0; axis < 3; ++axis) file.frames[4].position[axis] += kTurn(long(axis), 2);
  EXPECT_HAS(rejection(file), "uneven");
}

TEST_F(EnhancedDicom, EveryFrameIsRescaledByItsOwnSlope) {
  EnhancedFile file = turned(4);
  for (EnhancedFrame& frame : file.frames) frame.slope = 2, frame.intercept = 0;
  LoadedVolume loaded = load(file);
  expect_turned(loaded.volume, 4, 0, 2);
  EXPECT_EQ(loaded.volume.type(), VoxelType::UInt32);
  // Other stored values and slopes, same rescaled values.
  for (int k = 0; k < 4; ++k) {
    EnhancedFrame& frame = file.frames[std::size_t(k)];
    frame.value = 100 * (k + 1) + 7 * k;
    frame.slope = 0.5, frame.intercept = -3.5 * k;
  }
  loaded = load(file);
  EXPECT_EQ(loaded.volume.type(), VoxelType::Float32);
  expect_turned(loaded.volume, 4, 0, 0.5);
}

TEST_F(EnhancedDicom, OneFrameHasItsTrueGeometry) {
  const LoadedVolume loaded = load(turned(1));
  expect_turned(loaded.volume, 1);
  EXPECT_NEAR(loaded.volume.geometry().spacing_mm[2], 9, 1e-9);  // the slice's thickness
}

TEST_F(EnhancedDicom, FilesOfOneFrameEachMakeASeries) {
  const EnhancedFile whole = turned(4);
  for (std::size_t k = 0; k < 4; ++k) {
    EnhancedFile one = whole;
    one.frames = {whole.frames[k]};
    write_file(one, std::string(1, char('d' - char(k))));
  }
  expect_turned(read_volume(folder), 4);
}

TEST_F(EnhancedDicom, VolumesAreSeparatedByTheirDimension) {
  EnhancedFile file;
  for (int k = 0; k < 4; ++k) {  // sorted by position, with unsorted times
    for (const int time : {3, 1, 2}) {
      EnhancedFrame frame = turned(4).frames[std::size_t(k)];
      frame.value += 1000 * time;
      frame.time = time;
      file.frames.push_back(frame);
    }
  }
  const VolumeInfo info = read_volume_info(write_file(file), 2);
  EXPECT_EQ(info.frames, 3);
  EXPECT_EQ(info.frame, 2);
  for (int time = 1; time <= 3; ++time) {
    const LoadedVolume loaded = load(file, time);
    ASSERT_EQ(loaded.volume.geometry().size[2], 4);
    for (int k = 0; k < 4; ++k) EXPECT_EQ(loaded.volume.value(1, 2, k), 1000 * time + 100 * (k + 1) + 21);
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_HAS(loaded.warnings[0],
               "volume " + std::to_string(time) + " of 3 is loaded (temporal position " + std::to_string(time) + ")");
  }
  EXPECT_HAS(error_of([&] { load(file, 4); }), "3 volumes, volume 4 does not exist");
  write_volume(folder / "a.nrrd", load(file).volume);
  EXPECT_HAS(error_of([&] { load_volume(folder / "a.nrrd", 2); }), "one volume");
  // With a frame missing, the volumes no longer have identical positions.
  file.frames.pop_back();
  EXPECT_HAS(rejection(file), "duplicate");
}

TEST_F(EnhancedDicom, IndistinguishableVolumesAreRejected) {
  EnhancedFile file = turned(3);
  file.dimensions = false;
  const std::vector<EnhancedFrame> once = file.frames;
  file.frames.insert(file.frames.end(), once.begin(), once.end());
  EXPECT_HAS(rejection(file), "each of its 3 positions has 2 slices");
}

TEST_F(EnhancedDicom, StacksOfDifferentOrientationAreVolumes) {
  EnhancedFile file = turned(3);
  file.shared_axes = false;
  for (int k = 0; k < 3; ++k) {
    EnhancedFrame frame;
    frame.position = {0, 0, 3.0 * k};
    frame.stack = "2";
    file.frames.push_back(frame);
  }
  expect_turned(load(file, 1).volume, 3);
  const LoadedVolume second = load(file, 2);
  EXPECT_TRUE(second.volume.geometry().direction.isIdentity(1e-9));
  EXPECT_HAS(second.warnings[0], "stack 2");
}

/// Returns a multi-frame image without functional groups.
std::string classic(const std::string& modality, int frames, const std::function<void(test::DicomData&)>& place,
                    const std::function<void(test::DicomData&)>& pointer = {}) {
  test::DicomData data;
  data.text(0x0008, 0x0060, "CS", modality).text(0x0020, 0x000e, "UI", "1.2.3.4");
  if (place) place(data);
  data.us(0x0028, 0x0002, 1).text(0x0028, 0x0004, "CS", "MONOCHROME2");
  data.text(0x0028, 0x0008, "IS", std::to_string(frames));
  if (pointer) pointer(data);
  data.us(0x0028, 0x0010, 2).us(0x0028, 0x0011, 2).numbers(0x0028, 0x0030, {2, 3});
  data.us(0x0028, 0x0100, 8).us(0x0028, 0x0101, 8).us(0x0028, 0x0102, 7).us(0x0028, 0x0103, 0);
  std::string pixels;
  for (int f = 0; f < frames; ++f) pixels += std::string(4, char(10 * f + 10));
  data.raw(0x7fe0, 0x0010, "OB", pixels);
  return test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.3.1");
}

TEST_F(EnhancedDicom, UltrasoundWithoutPositionsIsATimeSeries) {
  const fs::path path = write("us.dcm", classic("US", 5, {}));
  const LoadedVolume loaded = load_volume(path, 3);
  EXPECT_EQ(loaded.volume.geometry().size, (std::array<int, 3>{2, 2, 1}));
  EXPECT_EQ(loaded.volume.value(1, 1, 0), 30);
  ASSERT_EQ(loaded.warnings.size(), 2u);
  EXPECT_HAS(loaded.warnings[0], "volume 3 of 5 is loaded (time 3)");
  EXPECT_HAS(loaded.warnings[1], "no position or orientation");
}

TEST_F(EnhancedDicom, FramesWithoutPositionsAreAssumedToBeSlices) {
  const LoadedVolume loaded = load_volume(write("ot.dcm", classic("OT", 5, {})));
  EXPECT_EQ(loaded.volume.geometry().size, (std::array<int, 3>{2, 2, 5}));
  ASSERT_EQ(loaded.warnings.size(), 2u);
  EXPECT_HAS(loaded.warnings[0], "5 frames have no positions");
  EXPECT_HAS(loaded.warnings[1], "no position or orientation");
}

TEST_F(EnhancedDicom, SlicesOfNuclearMedicineFollowTheirVector) {
  const auto place = [](test::DicomData& data) {
    data.numbers(0x0018, 0x0088, {4}).numbers(0x0020, 0x0032, {1, 2, 3}).numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
  };
  const auto pointer = [](test::DicomData& data) {
    data.raw(0x0028, 0x0009, "AT", test::bytes_of_numbers<std::uint16_t, std::uint16_t>(0x0054, 0x0080));
  };
  std::string bytes = classic("NM", 3, place, pointer);
  test::DicomData vector;
  vector.raw(0x0054, 0x0080, "US", test::bytes_of_numbers<std::uint16_t, std::uint16_t, std::uint16_t>(3, 1, 2));
  bytes.insert(bytes.find(std::string("\xe0\x7f\x10\x00", 4)), vector.bytes);
  const LoadedVolume loaded = load_volume(write("nm.dcm", bytes));
  EXPECT_TRUE(loaded.volume.geometry().spacing_mm.isApprox(Vector3d(3, 2, 4)));
  EXPECT_TRUE(loaded.volume.geometry().origin_mm.isApprox(Vector3d(1, 2, 3)));
  for (int k = 0; k < 3; ++k) EXPECT_EQ(loaded.volume.value(0, 0, k), 10 * ((k + 1) % 3 + 1));
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings[0];
}

/// Nuclear medicine of `frames` frames with Spacing Between Slices and Slice Thickness; 0: absent.
std::string nuclear(int frames, double distance, double thickness, bool vector = true) {
  const auto place = [&](test::DicomData& data) {
    if (thickness != 0) data.numbers(0x0018, 0x0050, {thickness});
    if (distance != 0) data.numbers(0x0018, 0x0088, {distance});
    data.numbers(0x0020, 0x0032, {1, 2, 100}).numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
  };
  const auto pointer = [&](test::DicomData& data) {
    if (vector) data.raw(0x0028, 0x0009, "AT", test::bytes_of_numbers<std::uint16_t, std::uint16_t>(0x0054, 0x0080));
  };
  std::string bytes = classic("NM", frames, place, pointer);
  if (!vector) return bytes;
  std::string order;
  for (int f = 0; f < frames; ++f) order += test::bytes_of_numbers(static_cast<std::uint16_t>(f + 1));
  test::DicomData numbers;
  numbers.raw(0x0054, 0x0080, "US", order);
  return bytes.insert(bytes.find(std::string("\xe0\x7f\x10\x00", 4)), numbers.bytes);
}

/// Expects frame f of classic() at z = 100 + f * step.
void expect_frames(const Volume& volume, int frames, double step) {
  ASSERT_EQ(volume.geometry().size[2], frames);
  for (int f = 0; f < frames; ++f) {
    const Vector3d at = volume.geometry().index_from_world() * Vector3d(1, 2, 100 + f * step);
    EXPECT_NEAR(at[2], std::round(at[2]), 1e-9);
    EXPECT_EQ(volume.value(0, 0, static_cast<int>(std::lround(at[2]))), 10 * f + 10) << "frame " << f;
  }
}

/// PS3.3 C.8.4.15: the sign of Spacing Between Slices is the direction of stacking.
TEST_F(EnhancedDicom, NegativeSpacingOfNuclearMedicineStacksBackwards) {
  for (const double distance : {5.0, -5.0}) {
    for (const bool vector : {true, false}) {
      const LoadedVolume loaded = load_volume(write("nm.dcm", nuclear(4, distance, 3, vector)));
      expect_frames(loaded.volume, 4, distance);
      EXPECT_EQ(loaded.warnings.size(), vector ? 0u : 1u);
    }
  }
  const LoadedVolume thick = load_volume(write("nm.dcm", nuclear(4, 0, 3)));
  expect_frames(thick.volume, 4, 3);
  EXPECT_HAS(thick.warnings.at(0), "assumed to be their thickness");
}

TEST_F(EnhancedDicom, NuclearMedicineOfTheReports) {
  const fs::path reports = test::data_folder() / "reports";
  REQUIRE_DATA(reports / "nm_neg.dcm");
  const LoadedVolume up = load_volume(reports / "nm_pos.dcm"), down = load_volume(reports / "nm_neg.dcm");
  EXPECT_TRUE(up.warnings.empty() && down.warnings.empty());
  const Eigen::Affine3d up_index = up.volume.geometry().index_from_world(),
                        down_index = down.volume.geometry().index_from_world();
  for (int f = 0; f < 16; ++f) {  // frames of both files are equal
    const Vector3d above = up_index * Vector3d(1, 1, 100 + 3 * f), below = down_index * Vector3d(1, 1, 100 - 3 * f);
    EXPECT_EQ(up.volume.value(16, 16, static_cast<int>(std::lround(above[2]))),
              down.volume.value(16, 16, static_cast<int>(std::lround(below[2]))))
        << "frame " << f;
  }
  const double low = (down.volume.geometry().world_from_index() * Vector3d(0, 0, 0)).z(),
               high = (down.volume.geometry().world_from_index() * Vector3d(0, 0, 15)).z();
  EXPECT_NEAR(std::min(low, high), 55, 1e-9);
  EXPECT_NEAR(std::max(low, high), 100, 1e-9);
}

TEST_F(EnhancedDicom, FramesWithoutPositionsKeepThePlaneOfTheFirst) {
  const auto place = [](double distance) {
    return [=](test::DicomData& data) {
      if (distance != 0) data.numbers(0x0018, 0x0088, {distance});
      data.numbers(0x0020, 0x0032, {10, 20, 30}).numbers(0x0020, 0x0037, {0, 1, 0, 0, 0, -1});
    };
  };
  for (const double distance : {4.0, -4.0, 0.0}) {
    const LoadedVolume loaded = load_volume(write("ct.dcm", classic("CT", 5, place(distance))));
    const VolumeGeometry& g = loaded.volume.geometry();
    EXPECT_EQ(g.size, (std::array<int, 3>{2, 2, 5}));
    EXPECT_TRUE(g.origin_mm.isApprox(Vector3d(10, 20, 30)));
    EXPECT_TRUE(g.direction.col(0).isApprox(Vector3d(0, 1, 0)));
    EXPECT_TRUE(g.direction.col(2).isApprox(Vector3d(-1, 0, 0)));
    EXPECT_EQ(g.spacing_mm[2], distance != 0 ? 4 : 1);
    for (int k = 0; k < 5; ++k) EXPECT_EQ(loaded.volume.value(0, 0, k), 10 * k + 10);
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_HAS(loaded.warnings[0], "in file order along the normal of the first frame");
    if (distance < 0) {
      EXPECT_HAS(loaded.warnings[0], "the minus sign of Spacing Between Slices (0018,0088) is ignored");
    }
    if (distance == 0) {
      EXPECT_HAS(loaded.warnings[0], "1 mm apart");
    }
  }
  const auto orientation = [](test::DicomData& data) { data.numbers(0x0020, 0x0037, {0, 1, 0, 0, 0, -1}); };
  const LoadedVolume loaded = load_volume(write("ct.dcm", classic("CT", 5, orientation)));
  EXPECT_TRUE(loaded.volume.geometry().direction.col(1).isApprox(Vector3d(0, 0, -1)));
  EXPECT_HAS(loaded.warnings.at(1), "no position");
}

}  // namespace
}  // namespace simplexseg
