// SPDX-License-Identifier: Apache-2.0
// Geometry and values against a reader that shares nothing with ours (judge_volumes.py), for files of every orientation
// in every format that is written, and for real ones.
#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::DicomData;

constexpr double kTolerance = 1e-4;  ///< mm

std::string output_of(const std::string& command) {
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return {};
  std::string text;
  char block[4096];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) text.append(block, n);
  return ::pclose(pipe) == 0 ? text : "";
}

/// The 48 ways to lay the axes of a grid along those of the patient, half of them left-handed.
std::vector<Eigen::Matrix3d> signed_permutations() {
  std::vector<Eigen::Matrix3d> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
      for (int a = 0; a < 3; ++a) m(order[static_cast<std::size_t>(a)], a) = signs >> a & 1 ? -1 : 1;
      all.push_back(m);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

/// Each voxel has a value of its own.
Volume numbered(const Eigen::Matrix3d& direction) {
  VolumeGeometry g = test::odd_geometry(test::Grid::Plain);
  g.direction = direction;
  Volume volume(g, VoxelType::Int16);
  std::int16_t next = -7;
  for (std::int16_t& v : volume.voxels<std::int16_t>()) v = next++;
  return volume;
}

/// A classic series: a file for each k.
void write_series(const fs::path& folder, const Volume& volume) {
  fs::create_directory(folder);
  const VolumeGeometry& g = volume.geometry();
  const Eigen::Affine3d world = g.world_from_index();
  for (int k = 0; k < g.size[2]; ++k) {
    const Eigen::Vector3d at = world * Eigen::Vector3d(0, 0, k);
    DicomData data;
    data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.4")
        .text(0x0008, 0x0018, "UI", "1.2.3." + std::to_string(k));
    data.text(0x0008, 0x0060, "CS", "MR")
        .text(0x0020, 0x000e, "UI", "1.2.3.4")
        .numbers(0x0020, 0x0032, {at[0], at[1], at[2]});
    const Eigen::Vector3d i = g.direction.col(0), j = g.direction.col(1);
    data.numbers(0x0020, 0x0037, {i[0], i[1], i[2], j[0], j[1], j[2]});
    test::describe_pixels(data, g.size[0], g.size[1], 0);
    data.numbers(0x0028, 0x0030, {g.spacing_mm[1], g.spacing_mm[0]})
        .numbers(0x0028, 0x1052, {-100})
        .numbers(0x0028, 0x1053, {1});
    std::string pixels;
    for (int y = 0; y < g.size[1]; ++y)
      for (int x = 0; x < g.size[0]; ++x)
        pixels += test::bytes_of_numbers(static_cast<std::uint16_t>(volume.value(x, y, k) + 100));
    data.raw(0x7fe0, 0x0010, "OW", pixels);
    std::ofstream(folder / (std::to_string(k) + ".dcm"), std::ios::binary)
        << test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.4");
  }
}

class GeometryTable : public test::FolderTest {
 protected:
  void SetUp() override {
    if (output_of("/usr/bin/python3 -c 'import pydicom; print(1)' 2>/dev/null") != "1\n")
      GTEST_SKIP() << "python3-pydicom is absent";
  }

  /// That ours is what the judge reads of each file; gives how many it could read.
  int compare(const std::vector<fs::path>& paths) {
    std::string list;
    for (const fs::path& path : paths) list += path.string() + "\n";
    const fs::path judge = fs::path(SIMPLEXSEG_SOURCE_DIR) / "tests/io/judge_volumes.py";
    std::istringstream said(
        output_of("/usr/bin/python3 '" + judge.string() + "' < '" + write("list", list).string() + "'"));
    std::string line;
    int files = 0;
    while (std::getline(said, line)) {
      SCOPED_TRACE(line);
      if (!line.starts_with("file ")) {
        ADD_FAILURE() << "the judge said " << line;
        break;
      }
      ++files;
      compare_one(line.substr(5), said);
      std::getline(said, line);  // the rest of the last number's
    }
    return files;
  }

  static void compare_one(const fs::path& path, std::istream& said) {
    std::array<int, 3> size{};
    int points = 0, wrong_place = 0, wrong_value = 0;
    said >> size[0] >> size[1] >> size[2] >> points;
    ASSERT_GE(points, 100);
    const Volume ours = read_volume(path);
    EXPECT_EQ(ours.geometry().size, size);
    const Eigen::Affine3d index_of = ours.geometry().index_from_world(), world_of = ours.geometry().world_from_index();
    for (int p = 0; p < points; ++p) {
      Eigen::Vector3d at;
      double value = 0;
      said >> at[0] >> at[1] >> at[2] >> value;
      const Eigen::Vector3d index = (index_of * at).array().round();
      const bool within = (index.array() >= 0).all() && index[0] < ours.geometry().size[0] &&
                          index[1] < ours.geometry().size[1] && index[2] < ours.geometry().size[2];
      if (!within || (world_of * index - at).norm() > kTolerance) {
        ++wrong_place;
        continue;
      }
      const double read = ours.value(int(index[0]), int(index[1]), int(index[2]));
      wrong_value += !(std::abs(read - value) <= 1e-6 * std::max(1.0, std::abs(value)));
    }
    EXPECT_TRUE(said) << "the judge stopped";
    EXPECT_EQ(wrong_place, 0);
    EXPECT_EQ(wrong_value, 0);
  }
};

TEST_F(GeometryTable, EveryOrientationInEveryFormat) {
  const Eigen::Matrix3d turn = test::odd_geometry(test::Grid::Rotated).direction;
  std::vector<fs::path> paths;
  int n = 0;
  for (const Eigen::Matrix3d& axes : signed_permutations()) {
    for (const bool oblique : {false, true}) {
      const Volume volume = numbered(oblique ? Eigen::Matrix3d(turn * axes) : axes);
      const std::string stem = std::to_string(n++);
      for (const char* ending : {".nii", ".nrrd", ".mha"}) {
        paths.push_back(folder / (stem + ending));
        write_volume(paths.back(), volume);
        // Labels written come back on the same voxels.
        const Volume read = read_volume(paths.back());
        ASSERT_TRUE(test::same_voxels(read, volume)) << paths.back();
        ASSERT_TRUE(read.geometry().same_grid(volume.geometry())) << paths.back();
      }
      paths.push_back(folder / stem);
      write_series(paths.back(), volume);
    }
  }
  ASSERT_EQ(n, 96);
  EXPECT_EQ(compare(paths), 96 * 4);
}

TEST_F(GeometryTable, RealFiles) {
  REQUIRE_DATA(test::data_folder() / "dicom_series");
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(test::data_folder())) {
    const std::string path = entry.path().string();
    if (path.ends_with(".nii.gz") && path.find("bad_input") == std::string::npos) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::set<std::string> taken;  // of many files of one kind the first few
  std::erase_if(paths, [&](const fs::path& path) {
    const std::string parent = path.parent_path().string();
    int n = 0;
    while (n < 4 && !taken.insert(parent + std::to_string(n)).second) ++n;
    return n == 4;
  });
  for (const char* name : {"dicom_series/ge_anatomical/001", "dicom_series/ge_anatomical/001_implicit",
                           "dicom_series/siemens_anatomical/001", "dicom_series/siemens_anatomical/001_implicit"})
    paths.push_back(test::data_folder() / name);
  EXPECT_EQ(compare(paths), static_cast<int>(paths.size()));
}

}  // namespace
}  // namespace simplexseg
