// SPDX-License-Identifier: Apache-2.0 Compares geometry and voxel values with an independent reader
// (independent_reader.py), for files of every orientation in every format, and for real files.
#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/number_text.h"
#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::DicomData;
using test::output_of;

constexpr double kTolerance = 1e-4;  ///< mm

/// The 48 assignments of the axes of a grid to the axes of the patient; half of them are left-handed.
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

/// Volume in which each voxel has a different value.
Volume numbered(const Eigen::Matrix3d& direction) {
  VolumeGeometry g = test::odd_geometry(test::Grid::Plain);
  g.direction = direction;
  Volume volume(g, VoxelType::Int16);
  std::int16_t next = -7;
  for (std::int16_t& v : volume.voxels<std::int16_t>()) v = next++;
  return volume;
}

/// Voxels as a raw file of 16-bit integers, little- or big-endian.
std::string raw_voxels(const Volume& volume, bool big_endian = false) {
  std::string bytes(static_cast<const char*>(volume.data()), volume.bytes());
  for (std::size_t b = 0; big_endian && b < bytes.size(); b += 2) std::swap(bytes[b], bytes[b + 1]);
  return bytes;
}

std::string text_of(const Eigen::Vector3d& v, const char* between) {
  return general_text(v[0], 17) + between + general_text(v[1], 17) + between + general_text(v[2], 17);
}
std::string text_of(const std::array<int, 3>& v) {
  return std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]);
}

/// Detached NRRD header in RAS.
std::string nhdr_text(const VolumeGeometry& g, const std::string& voxels) {
  const Eigen::Vector3d ras(-1, -1, 1);
  std::string text = "NRRD0005\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: " + text_of(g.size);
  text += "\nspace directions:";
  for (int a = 0; a < 3; ++a)
    text.append(" (").append(text_of(ras.cwiseProduct(g.direction.col(a)) * g.spacing_mm[a], ",")).append(")");
  return text + "\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: (" +
         text_of(ras.cwiseProduct(g.origin_mm), ",") + ")\ndata file: " + voxels + "\n";
}

/// Detached MetaImage header.
std::string mhd_text(const VolumeGeometry& g, const std::string& voxels) {
  std::string text =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nTransformMatrix =";
  for (int a = 0; a < 3; ++a) text.append(" ").append(text_of(g.direction.col(a), " "));
  return text + "\nOffset = " + text_of(g.origin_mm, " ") + "\nElementSpacing = " + text_of(g.spacing_mm, " ") +
         "\nDimSize = " + text_of(g.size) + "\nElementType = MET_SHORT\nElementDataFile = " + voxels + "\n";
}

/// Command of minc-tools that converts raw voxels to MINC; `version`: "-2" for MINC 2, empty for MINC 1. Axis a of the
/// file is parallel to the world axis given by `axes`, rotated by `turn`.
std::string mnc_command(const fs::path& voxels, const fs::path& to, const VolumeGeometry& g,
                        const Eigen::Matrix3d& axes, const Eigen::Matrix3d& turn, const std::string& version) {
  const Eigen::Vector3d ras(-1, -1, 1);
  std::string order,
      command = "rawtominc " + version + " -clobber -short -signed -scan_range -input '" + voxels.string() + "'";
  const Eigen::Matrix3d cosines = ras.asDiagonal() * turn;
  const Eigen::Vector3d start = cosines.inverse() * ras.cwiseProduct(g.origin_mm);
  for (int a = 2; a >= 0; --a) {  // the slowest first
    int row = 0;
    while (axes(row, a) == 0) ++row;
    const char name = "xyz"[row];
    order += name;
    const auto option = [&](const char* what, const std::string& value) {
      command.append(" -").append(1, name).append(what).append(" ").append(value);
    };
    option("step", fixed_text(axes(row, a) * g.spacing_mm[a], 6));
    option("dircos", text_of(cosines.col(row), " "));
    option("start", general_text(start[row], 17));
  }
  command += " -" + order + " '" + to.string() + "'";
  for (int a = 2; a >= 0; --a) command.append(" ").append(std::to_string(g.size[static_cast<std::size_t>(a)]));
  return command;
}

/// Enhanced multi-frame DICOM file whose frames are not in spatial order.
std::string enhanced_bytes(const Volume& volume) {
  const VolumeGeometry& g = volume.geometry();
  test::EnhancedFile file;
  file.columns = g.size[0], file.rows = g.size[1];
  file.between_rows_and_columns = {g.spacing_mm[1], g.spacing_mm[0]};
  for (int n = 0; n < g.size[2]; ++n) {
    const int k = (n + 1) % g.size[2];
    test::EnhancedFrame& frame = file.frames.emplace_back();
    const Eigen::Vector3d at = g.world_from_index() * Eigen::Vector3d(0, 0, k);
    frame.position = {at[0], at[1], at[2]};
    frame.value = 100 * k, frame.slope = 1 + k, frame.intercept = -k;
    for (int r = 0; r < 3; ++r) {
      frame.axes[static_cast<std::size_t>(r)] = g.direction(r, 0);
      frame.axes[static_cast<std::size_t>(r) + 3] = g.direction(r, 1);
    }
  }
  return file.bytes();
}

/// Bytes of a GIPL file; all its numbers are big-endian.
std::string gipl_bytes(const Volume& volume) {
  std::string bytes(256, '\0');
  const auto put = [&](std::size_t at, auto value) {
    test::patch(bytes, at, value);
    std::reverse(bytes.begin() + static_cast<long>(at), bytes.begin() + static_cast<long>(at + sizeof value));
  };
  const VolumeGeometry& g = volume.geometry();
  for (std::size_t a = 0; a < 3; ++a) {
    put(2 * a, static_cast<std::uint16_t>(g.size[a]));
    put(10 + 4 * a, static_cast<float>(g.spacing_mm[static_cast<int>(a)]));
    put(204 + 8 * a, g.origin_mm[static_cast<int>(a)]);
  }
  put(8, std::uint16_t(15));
  put(252, std::uint32_t(719555000));
  return bytes + raw_voxels(volume, true);
}

/// Writes a DICOM series of single-frame files, one per slice.
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
    if (output_of("/usr/bin/python3 -c 'import h5py, nibabel, numpy, PIL, pydicom; print(1)' 2>/dev/null") != "1\n")
      GTEST_SKIP() << "python3-pydicom, -numpy, -pil, -nibabel or -h5py is missing";
  }

  /// Compares our reading of each file with the independent reader's; returns the number of files that it could read.
  int compare(const std::vector<fs::path>& paths) {
    std::string list;
    for (const fs::path& path : paths) list += path.string() + "\n";
    const fs::path reader = fs::path(SIMPLEXSEG_SOURCE_DIR) / "tests/io/independent_reader.py";
    std::istringstream output(
        output_of("/usr/bin/python3 '" + reader.string() + "' < '" + write("list", list).string() + "' 2>/dev/null"));
    std::string line;
    int files = 0;
    while (std::getline(output, line)) {
      SCOPED_TRACE(line);
      if (!line.starts_with("file ")) {
        ADD_FAILURE() << "unexpected output of the independent reader: " << line;
        break;
      }
      ++files;
      compare_one(line.substr(5), output);
      std::getline(output, line);  // rest of the line of the last number
    }
    return files;
  }

  static void compare_one(const fs::path& path, std::istream& output) {
    std::array<int, 3> size{};
    int points = 0, wrong_place = 0, wrong_value = 0;
    output >> size[0] >> size[1] >> size[2] >> points;
    ASSERT_GE(points, 100);
    const Volume ours = read_volume(path);
    EXPECT_EQ(ours.geometry().size, size);
    const Eigen::Affine3d index_of = ours.geometry().index_from_world(), world_of = ours.geometry().world_from_index();
    for (int p = 0; p < points; ++p) {
      Eigen::Vector3d at;
      std::string number;  // may be 'nan'
      output >> at[0] >> at[1] >> at[2] >> number;
      const double value = parse_number(number).value_or(std::nan(""));
      const Eigen::Vector3d index = (index_of * at).array().round();
      const bool within = (index.array() >= 0).all() && index[0] < ours.geometry().size[0] &&
                          index[1] < ours.geometry().size[1] && index[2] < ours.geometry().size[2];
      if (!within || (world_of * index - at).norm() > kTolerance) {
        ++wrong_place;
        continue;
      }
      const double read = ours.value(int(index[0]), int(index[1]), int(index[2]));
      wrong_value +=
          !(std::abs(read - value) <= 1e-6 * std::max(1.0, std::abs(value)) || (read != read && value != value));
    }
    EXPECT_TRUE(output) << "the independent reader stopped";
    EXPECT_EQ(wrong_place, 0);
    EXPECT_EQ(wrong_value, 0);
  }
};

/// Calls f 96 times with a signed permutation of the axes, an additional rotation, and a volume of this orientation.
template <class F>
void each_orientation(F&& f) {
  const Eigen::Matrix3d turn = test::odd_geometry(test::Grid::Rotated).direction;
  for (const Eigen::Matrix3d& axes : signed_permutations()) {
    for (const Eigen::Matrix3d& turned : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turn})
      f(axes, turned, numbered(turned * axes));
  }
}

TEST_F(GeometryTable, EveryOrientationInEveryFormat) {
  std::vector<fs::path> paths;
  int n = 0;
  each_orientation([&](const auto&, const auto&, const Volume& volume) {
    const std::string stem = std::to_string(n++);
    for (const char* ending : {".nii", ".nrrd", ".mha"}) {
      paths.push_back(folder / (stem + ending));
      write_volume(paths.back(), volume);
      // Labels are read back on the same voxels.
      const Volume read = read_volume(paths.back());
      ASSERT_TRUE(test::same_voxels(read, volume)) << paths.back();
      ASSERT_TRUE(read.geometry().same_grid(volume.geometry())) << paths.back();
    }
    paths.push_back(folder / stem);
    write_series(paths.back(), volume);
  });
  ASSERT_EQ(n, 96);
  EXPECT_EQ(compare(paths), 96 * 4);
}

TEST_F(GeometryTable, EveryOrientationPackedInTwoFilesAndInFrames) {
  std::vector<fs::path> paths;
  int n = 0;
  each_orientation([&](const auto&, const auto&, const Volume& volume) {
    const std::string stem = std::to_string(n++);
    write_volume(folder / (stem + ".nii.gz"), volume);
    write_labels(folder / (stem + ".seg.nrrd"), volume, {{1, "kidney", Colour{1, 2, 3}}});
    for (const char* ending : {".nii.gz", ".seg.nrrd"}) paths.push_back(folder / (stem + ending));
    write(stem + ".raw", raw_voxels(volume));
    paths.push_back(write(stem + ".nhdr", nhdr_text(volume.geometry(), stem + ".raw")));
    paths.push_back(write(stem + ".mhd", mhd_text(volume.geometry(), stem + ".raw")));
    paths.push_back(write(stem + ".dcm", enhanced_bytes(volume)));
  });
  EXPECT_EQ(compare(paths), 96 * 5);
}

TEST_F(GeometryTable, EveryOrientationInMinc) {
  if (output_of("command -v rawtominc").empty()) GTEST_SKIP() << "minc-tools is absent";
  std::vector<fs::path> paths;
  std::string commands = "set -e\n";
  int n = 0;
  each_orientation([&](const Eigen::Matrix3d& axes, const Eigen::Matrix3d& turn, const Volume& volume) {
    const int permutation = n / 2, oblique = n % 2;
    ++n;
    if (permutation % 2 != oblique) return;  // alternately straight and oblique, since each file starts a program
    paths.push_back(folder / (std::to_string(paths.size()) + ".mnc"));
    write("voxels.raw", raw_voxels(volume));
    commands += mnc_command(folder / "voxels.raw", paths.back(), volume.geometry(), axes, turn,
                            paths.size() % 8 == 0 ? "" : "-2") +
                "\n";
  });
  ASSERT_EQ(output_of("sh '" + write("commands", commands + "echo made\n").string() + "'"), "made\n");
  EXPECT_EQ(compare(paths), 48);
}

/// Analyze and GIPL have voxel sizes, GIPL also a position. Their axes are assumed to be LPS, with a warning.
TEST_F(GeometryTable, FormatsWithoutOrientation) {
  const Volume volume = numbered(Eigen::Matrix3d::Identity());
  std::string header = test::nifti_bytes(folder, volume).substr(0, 252) + std::string(96, '\0');
  test::patch(header, 108, 0.0f);
  write("old.img", raw_voxels(volume));
  std::string gipl = gipl_bytes(volume);
  const std::vector<fs::path> paths{write("old.hdr", header), write("plain.gipl", gipl),
                                    test::write_gzip(folder / "packed.gipl.gz", gipl)};
  EXPECT_EQ(compare(paths), 3);
  for (const fs::path& path : paths)
    EXPECT_HAS(load_volume(path).warnings.at(0), "the patient's left and right are unknown");
}

TEST_F(GeometryTable, RealFiles) {
  REQUIRE_DATA(test::data_folder() / "dicom_series");
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(test::data_folder())) {
    const std::string path = entry.path().string();
    const bool is_damaged = path.find("/bad_input/") != path.npos;
    // Without a code the standard defines no orientation, and the independent reader does not read the file.
    const bool has_no_code = path.ends_with("/reports/none.nii.gz");
    if (path.ends_with(".nii.gz") && !is_damaged && !has_no_code) paths.push_back(entry.path());
  }
  // Not compared in reports: echo (the independent reader does not separate volumes), slopecomma (refused), and labels
  // and contours (other tests).
  for (const char* name : {"micro8", "latin1name", "nm_pos.dcm", "nm_neg.dcm"}) {
    const fs::path path = test::data_folder() / "reports" / name;
    if (fs::exists(path)) paths.push_back(path);
  }
  for (const char* name : {"ge_anatomical/001", "ge_anatomical/001_implicit", "ge_anatomical/001_single_slice",
                           "siemens_anatomical/001", "siemens_anatomical/001_implicit", "failing_gantrytilting/001"})
    paths.push_back(test::data_folder() / "dicom_series" / name);
  EXPECT_GT(paths.size(), 100u);
  EXPECT_EQ(compare(paths), static_cast<int>(paths.size()));
}

TEST_F(GeometryTable, ACompressedSeries) {
  REQUIRE_DATA(test::data_folder() / "dicom_series");
  const std::vector<fs::path> paths{test::data_folder() / "dicom_series/generic_compressed_j2k/001"};
  EXPECT_EQ(compare(paths), 1);
}

/// Unusual files of other programs, many of which are rejected.
TEST_F(GeometryTable, OddFiles) {
  REQUIRE_DATA(test::data_folder() / "bad_input");
  std::vector<fs::path> read;
  for (const auto& entry : fs::recursive_directory_iterator(test::data_folder() / "bad_input")) {
    if (!entry.is_regular_file()) continue;
    try {
      load_volume(entry.path());
      read.push_back(entry.path());
    } catch (const Error&) {
      continue;
    }
  }
  EXPECT_GT(read.size(), 40u);
  EXPECT_GE(compare(read), static_cast<int>(read.size()) - 1);  // all but lossy JPEG, which decoders read differently
}

}  // namespace
}  // namespace simplexseg
