// SPDX-License-Identifier: Apache-2.0
// Reading one volume of a 4D file, in every format and layout.
#include <gtest/gtest.h>

#include "dicom_slices.h"
#include "io/scene/load_input.h"
#include "io/scene/scene_io.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

using test::bytes_of;
using test::error_of;

constexpr int kSmallColumns = 3, kSmallRows = 2, kSmallSlices = 2, kVolumes = 4;

/// Value of a voxel, unique for each volume and position.
std::int16_t voxel(int volume, int place) { return static_cast<std::int16_t>(1000 * volume + place); }

class FourDimensions : public test::FolderTest {
 protected:
  /// Voxels of all volumes, one volume after the other or interleaved.
  static std::string voxels(bool interleaved = false) {
    constexpr int count = kSmallColumns * kSmallRows * kSmallSlices;
    std::string bytes(2 * count * kVolumes, '\0');
    for (int v = 1; v <= kVolumes; ++v) {
      for (int i = 0; i < count; ++i)
        test::patch(bytes, 2 * static_cast<std::size_t>(interleaved ? i * kVolumes + v - 1 : (v - 1) * count + i),
                    voxel(v, i));
    }
    return bytes;
  }

  void expect_all(const fs::path& path) {
    SCOPED_TRACE(path);
    EXPECT_EQ(count_volumes(path), kVolumes);
    for (int v = 1; v <= kVolumes; ++v) {
      const LoadedVolume read = load_volume(path, v);
      EXPECT_EQ(read.frames, kVolumes);
      EXPECT_EQ(read.frame, v);
      ASSERT_EQ(read.volume.geometry().size, (std::array<int, 3>{kSmallColumns, kSmallRows, kSmallSlices}));
      for (int i = 0; i < kSmallColumns * kSmallRows * kSmallSlices; ++i) {
        ASSERT_EQ(read.volume.value(i % kSmallColumns, i / kSmallColumns % kSmallRows, i / kSmallColumns / kSmallRows),
                  voxel(v, i))
            << "volume " << v << ", voxel " << i;
      }
      const std::string warning = "4D: volume " + std::to_string(v) + " of 4 is loaded";
      EXPECT_TRUE(std::find(read.warnings.begin(), read.warnings.end(), warning) != read.warnings.end());
    }
    EXPECT_HAS(error_of([&] { load_volume(path, 5); }), "it contains 4 volumes, volume 5 does not exist");
    EXPECT_HAS(error_of([&] { load_volume(path, 0); }), "choose a volume from 1 to 4");
  }

  std::string nifti() {
    VolumeGeometry g = test::odd_geometry(test::Grid::Rotated);
    g.size = {kSmallColumns, kSmallRows, kSmallSlices};
    std::string bytes = test::nifti_bytes(folder, Volume(g, VoxelType::Int16)).substr(0, 352);
    test::patch(bytes, 40, std::int16_t(4));
    test::patch(bytes, 48, std::int16_t(kVolumes));
    return bytes + voxels();
  }
};

TEST_F(FourDimensions, EveryFormat) {
  expect_all(write("plain.nii", nifti()));
  expect_all(test::write_gzip(folder / "packed.nii.gz", nifti()));
  std::string scaled = nifti();  // as floats
  test::patch(scaled, 112, 1.0f);
  test::patch(scaled, 116, 0.0f);
  expect_all(write("scaled.nii", scaled));

  const std::string meta = "ObjectType = Image\nNDims = 4\nDimSize = 3 2 2 4\nElementType = MET_SHORT\n";
  expect_all(write("plain.mha", meta + "ElementDataFile = LOCAL\n" + voxels()));
  std::string text;
  for (int v = 1; v <= kVolumes; ++v) {
    for (int i = 0; i < kSmallColumns * kSmallRows * kSmallSlices; ++i) text += std::to_string(voxel(v, i)) + " ";
  }
  expect_all(write("text.mha", meta + "BinaryData = False\nElementDataFile = LOCAL\n" + text));
  // One file for every two slices: volumes begin inside files and skip others.
  std::string list = meta + "ElementDataFile = LIST 3\n";
  for (int f = 0; f < kVolumes; ++f) {
    const std::string name = "part" + std::to_string(f);
    write(name, voxels().substr(static_cast<std::size_t>(f) * 24, 24));
    list += name + "\n";
  }
  expect_all(write("list.mhd", list));

  std::string gipl(256, '\0');
  const auto big = [&](std::size_t at, auto value) {
    test::patch(gipl, at, value);
    std::reverse(gipl.begin() + static_cast<long>(at), gipl.begin() + static_cast<long>(at + sizeof value));
  };
  for (std::size_t a = 0; a < 4; ++a) big(2 * a, static_cast<std::uint16_t>(std::array{3, 2, 2, 4}[a]));
  big(8, std::uint16_t(15));
  for (std::size_t a = 0; a < 3; ++a) big(10 + 4 * a, 1.0f);
  big(252, std::uint32_t(719555000));
  std::string swapped = voxels();
  for (std::size_t i = 0; i < swapped.size(); i += 2) std::swap(swapped[i], swapped[i + 1]);
  expect_all(write("plain.gipl", gipl + swapped));
}

TEST_F(FourDimensions, Minc) {
  if (std::system("command -v rawtominc >/dev/null") != 0) GTEST_SKIP() << "minc-tools is absent";
  const fs::path raw = write("voxels.raw", voxels());
  for (const char* version : {"-2", ""}) {
    const fs::path path = folder / (std::string("a") + version + ".mnc");
    const std::string command = std::string("rawtominc ") + version + " -short -signed -scan_range -input '" +
                                raw.string() + "' -xstep 1 -ystep 1 -zstep 1 '" + path.string() + "' 4 2 2 3";
    ASSERT_EQ(std::system(command.c_str()), 0);
    expect_all(path);
  }
}

/// NRRD names its axes; the time axis can be the first, as in sequences of 3D Slicer.
TEST_F(FourDimensions, AxesOfNrrd) {
  const std::string start = "NRRD0004\ntype: short\ndimension: 4\nspace: LPS\nendian: little\n";
  const std::string last = "sizes: 3 2 2 4\nspace directions: (1,0,0) (0,1,0) (0,0,1) none\n",
                    first = "sizes: 4 3 2 2\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n";
  expect_all(write("last.nrrd", start + last + "kinds: domain domain domain time\nencoding: raw\n\n" + voxels()));
  expect_all(write("first.nrrd", start + first + "kinds: list domain domain domain\nencoding: raw\n\n" + voxels(true)));
  test::write_gzip(folder / "voxels.gz", voxels(true));
  expect_all(write("packed.nhdr", start + first + "encoding: gzip\ndata file: voxels.gz\n"));
  const fs::path mixed = write("between.nrrd", start +
                                                   "sizes: 3 4 2 2\nspace directions: (1,0,0) none (0,1,0) (0,0,1)\n"
                                                   "kinds: domain time domain domain\nencoding: raw\n\n" +
                                                   voxels());
  EXPECT_EQ(count_volumes(mixed), 1);
  for (const int volume : {1, 2})
    EXPECT_HAS(error_of([&] { load_volume(mixed, volume); }), "its 4 volumes are interleaved within slices");
}

TEST_F(FourDimensions, TruncatedAndDamagedFilesAreRejectedForAnyVolume) {
  const std::string whole = nifti();
  EXPECT_HAS(error_of([&] { load_volume(write("short.nii", whole.substr(0, whole.size() - 1)), 1); }), "truncated");
  test::write_gzip(folder / "whole.nii.gz", whole);
  std::string packed = bytes_of(folder / "whole.nii.gz");
  packed[packed.size() - 6] ^= 1;  // a byte of the checksum
  write("damaged.nii.gz", packed);
  EXPECT_HAS(error_of([&] { load_volume(folder / "damaged.nii.gz", kVolumes); }), "damaged");
}

/// Regression: a decimal comma in the locale of the process changed the order of the echoes.
TEST_F(FourDimensions, EchoesAreOrderedByNumber) {
  const fs::path echoes = test::data_folder() / "reports/echo";
  REQUIRE_DATA(echoes);
  EXPECT_HAS(load_volume(echoes, 1).warnings.at(0), "(echo time 4.6)");
  EXPECT_HAS(load_volume(echoes, 2).warnings.at(0), "(echo time 12.3)");
}

TEST_F(FourDimensions, EchoesThatAreNotNumbersAreRefused) {
  test::write_echoes(folder / "echoes", "4,6", "12,3");
  const std::string message = test::error_of([&] { read_volume_info(folder / "echoes"); });
  EXPECT_HAS(message, "its volumes differ in the echo time, which is '");
  EXPECT_HAS(message, "not a number; correct this value");
  for (int n = 0; n < 3; ++n)  // one echo: its time has no influence
    test::CtSlice{.z_mm = 2.0 * n, .value = 46, .echo = "4,6"}.write(folder / "one" / std::to_string(n));
  EXPECT_EQ(load_volume(folder / "one").volume.value(0, 0, 2), 46);
}

TEST_F(FourDimensions, ScenesNameTheirVolume) {
  write("four.nii", nifti());
  write("scene.json", R"({"simplexseg_scene": 1, "volume": "four.nii", "volume_number": 3})");
  const LoadedInput input = load_input(folder / "scene.json");
  EXPECT_EQ(input.volume.value(0, 0, 0), voxel(3, 0));
  write_scene(folder / "again.json", input.scene);
  EXPECT_EQ(load_input(folder / "again.json").volume.value(1, 0, 0), voxel(3, 1));
  write("beyond.json", R"({"simplexseg_scene": 1, "volume": "four.nii", "volume_number": 5})");
  EXPECT_HAS(error_of([&] { load_scene(folder / "beyond.json"); }), "volume 5");
  write("none.json", R"({"simplexseg_scene": 1, "volume": "four.nii", "volume_number": 0})");
  EXPECT_HAS(error_of([&] { load_scene(folder / "none.json"); }), "volume_number");
  const LoadedInput opened = load_input(folder / "four.nii", 2);
  EXPECT_EQ(opened.volume.value(0, 0, 0), voxel(2, 0));
  EXPECT_EQ(opened.scene.volume_number, 2);
}

}  // namespace
}  // namespace simplexseg
