// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "dicom_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::data_folder;
using test::error_of;

class Dicom : public test::FolderTest {
 protected:
  static fs::path series(const std::string& name) { return data_folder() / "dicom_series" / name; }
  void copy(const fs::path& from, const std::string& to) { fs::copy_file(from, folder / to); }
  /// Copies the four slices of the GE series to the files a, b, c, d, in the order of their numbers.
  void copy_four() {
    const char* const names[] = {"a", "b", "c", "d"};
    for (int i = 0; i < 4; ++i)
      copy(series("ge_anatomical/001/IM-0001-011") += std::to_string(2 + i) + "-0001.dcm", names[i]);
  }
};

/// Expects equal values at equal positions, independent of the order of the axes.
void expect_same_world(const Volume& a, const Volume& b) {
  ASSERT_EQ(a.geometry().voxel_count(), b.geometry().voxel_count());
  const Eigen::Affine3d b_from_a = b.geometry().index_from_world() * a.geometry().world_from_index();
  const auto [ni, nj, nk] = a.geometry().size;
  std::size_t wrong = 0;
  double off = 0;
  for (int k = 0; k < nk; ++k) {
    for (int j = 0; j < nj; ++j) {
      for (int i = 0; i < ni; ++i) {
        const Eigen::Vector3d exact = b_from_a * Eigen::Vector3d(i, j, k), index = exact.array().round();
        off = std::max(off, (exact - index).cwiseAbs().maxCoeff());
        for (int axis = 0; axis < 3; ++axis) ASSERT_TRUE(index[axis] >= 0 && index[axis] < b.geometry().size[axis]);
        wrong += a.value(i, j, k) != b.value(int(index[0]), int(index[1]), int(index[2]));
      }
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_LT(off, 0.02);
}

TEST_F(Dicom, SeriesEqualTheirNiftiReference) {
  REQUIRE_DATA(series(""));
  for (const char* name : {"ge_anatomical/001", "ge_anatomical/001_implicit", "siemens_anatomical/001",
                           "siemens_anatomical/001_implicit", "generic_compressed_j2k/001"}) {
    const LoadedVolume loaded = load_volume(series(name));
    EXPECT_EQ(loaded.format, "DICOM series");
    EXPECT_TRUE(loaded.warnings.empty()) << name;
    EXPECT_EQ(read_volume_info(series(name)).file_count, 4);
    for (const char* truth : {"_ground_truth.nii.gz", "_ground_truth_reoriented.nii.gz"}) {
      const Volume expected = read_volume(series(std::string(name) + truth));
      expect_same_world(loaded.volume, expected);
      if (expected.type() == VoxelType::Int16 || expected.type() == VoxelType::UInt16) {
        EXPECT_EQ(loaded.volume.type(), expected.type()) << name;
      }
    }
  }
}

TEST_F(Dicom, ASingleSliceIsAVolumeOfOneSlice) {
  REQUIRE_DATA(series(""));
  const fs::path file = series("ge_anatomical/001_single_slice/IM-0001-0112-0001.dcm");
  const LoadedVolume loaded = load_volume(file);
  EXPECT_EQ(loaded.format, "DICOM");
  EXPECT_EQ(loaded.volume.geometry().size, (std::array<int, 3>{256, 256, 1}));
  expect_same_world(loaded.volume, read_volume(series("ge_anatomical/001_single_slice_ground_truth.nii.gz")));
  expect_same_world(read_volume(file.parent_path()), loaded.volume);
}

TEST_F(Dicom, Jpeg2000CtWithoutExtensions) {
  const fs::path ct = data_folder() / "ct_abdomen_dicom";
  REQUIRE_DATA(ct);
  const LoadedVolume loaded = load_volume(ct);
  EXPECT_TRUE(loaded.warnings.empty());
  const VolumeGeometry& g = loaded.volume.geometry();
  EXPECT_EQ(loaded.volume.type(), VoxelType::Int16);
  EXPECT_EQ(g.size, (std::array<int, 3>{512, 512, 20}));
  EXPECT_TRUE(g.spacing_mm.isApprox(Eigen::Vector3d(0.9765625, 0.9765625, 2)));
  EXPECT_TRUE(g.origin_mm.isApprox(Eigen::Vector3d(-249.51171875, -437.51171875, -804.5)));
  // The grid of the labels is left-handed, with j reversed. In world coordinates both agree: labelled bone is bright.
  const Volume labels = read_volume(data_folder() / "ct_abdomen_dicom_labels.nii.gz");
  EXPECT_LT(labels.geometry().direction.determinant(), 0);
  const Eigen::Affine3d ct_from_labels = g.index_from_world() * labels.geometry().world_from_index();
  EXPECT_TRUE((ct_from_labels * Eigen::Vector3d(7, 0, 3)).isApprox(Eigen::Vector3d(7, 511, 3), 1e-4));
  double sum = 0, mirrored = 0, count = 0;
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 512; ++j) {
      for (int i = 0; i < 512; ++i) {
        const int label = int(labels.value(i, j, k));
        if (label < 25 || label > 50) continue;  // sacrum and vertebrae
        sum += loaded.volume.value(i, 511 - j, k);
        mirrored += loaded.volume.value(i, j, k);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_GT(sum / count, 100);
  EXPECT_LT(mirrored / count, sum / count - 50);
}

TEST_F(Dicom, GantryTiltBecomesAShearedGrid) {
  REQUIRE_DATA(series(""));
  const LoadedVolume loaded = load_volume(series("failing_gantrytilting/001"));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_HAS(loaded.warnings[0], "tilted gantry");
  EXPECT_HAS(loaded.warnings[0], "14 degrees");
  const Eigen::Affine3d world_from_index = loaded.volume.geometry().world_from_index();
  // Positions of the first and the last file, exactly.
  EXPECT_TRUE((world_from_index * Eigen::Vector3d(0, 0, 0))
                  .isApprox(Eigen::Vector3d(-106.791015625, -256.61886606561, -61.951915066986), 1e-9));
  EXPECT_TRUE((world_from_index * Eigen::Vector3d(0, 0, 3))
                  .isApprox(Eigen::Vector3d(-106.791015625, -256.61886606561, -46.951915066986), 1e-9));
  write_volume(folder / "tilt.nii.gz", loaded.volume);
  EXPECT_TRUE(read_volume(folder / "tilt.nii.gz").geometry().same_grid(loaded.volume.geometry(), 1e-4));
}

TEST_F(Dicom, MixedOrientationsAreRejected) {
  REQUIRE_DATA(series(""));
  const std::string text = error_of([&] { load_volume(series("failing_sliceorientation/001")); });
  EXPECT_HAS(text, "orientation");
  EXPECT_HAS(text, "IM-0001-0002-0001.dcm");
  error_of([&] { read_volume_info(series("failing_sliceorientation/001")); });
}

TEST_F(Dicom, TwoSlicesGiveAWarning) {
  REQUIRE_DATA(series(""));
  const LoadedVolume loaded = load_volume(series("failing_slicecount/001"));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_HAS(loaded.warnings[0], "only 2 slices");
  expect_same_world(loaded.volume, read_volume(series("failing_slicecount/001_ground_truth.nii.gz")));
}

TEST_F(Dicom, MissingAndDuplicateSlicesAreListedInOneMessage) {
  REQUIRE_DATA(series(""));
  copy_four();
  expect_same_world(read_volume(folder), read_volume(series("ge_anatomical/001_ground_truth.nii.gz")));
  fs::remove(folder / "c");
  std::string text = error_of([&] { load_volume(folder); });
  EXPECT_HAS(text, "1 missing");
  EXPECT_HAS(text, "'b'");
  EXPECT_HAS(text, "'d'");
  EXPECT_EQ(text.find("'a'"), std::string::npos) << text;
  copy(folder / "a", "again");
  text = error_of([&] { load_volume(folder); });
  EXPECT_HAS(text, "1 missing");
  EXPECT_HAS(text, "1 duplicate");
  EXPECT_HAS(text, "'a' and 'again'");
  error_of([&] { read_volume_info(folder); });
}

TEST_F(Dicom, OrderOfNamesDoesNotMatter) {
  REQUIRE_DATA(series(""));
  const char* const names[] = {"z.dcm", "m", "a.IMA", "q.1"};
  for (int i = 0; i < 4; ++i)
    copy(series("siemens_anatomical/001/IM-0001-011") += std::to_string(2 + i) + "-0001.dcm", names[i]);
  write("README", "Other files may lie beside the slices.\n");
  write("notes.txt", "");
  fs::create_directory(folder / "sub");
  const LoadedVolume loaded = load_volume(folder);
  EXPECT_TRUE(loaded.warnings.empty());
  expect_same_world(loaded.volume, read_volume(series("siemens_anatomical/001_ground_truth.nii.gz")));
}

TEST_F(Dicom, TheLargestOfSeveralSeriesIsLoaded) {
  REQUIRE_DATA(series(""));
  copy_four();
  for (int i = 0; i < 3; ++i) {
    copy(series("siemens_anatomical/001/IM-0001-011") += std::to_string(2 + i) + "-0001.dcm",
         "other" + std::to_string(i));
  }
  const LoadedVolume loaded = load_volume(folder);
  expect_same_world(loaded.volume, read_volume(series("ge_anatomical/001_ground_truth.nii.gz")));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_HAS(loaded.warnings[0], "2 series");
  EXPECT_HAS(loaded.warnings[0], "other0");
}

TEST_F(Dicom, TruncatedSlicesAreNamed) {
  REQUIRE_DATA(series(""));
  copy_four();
  const std::string slice = bytes_of(folder / "b");
  write("b", slice.substr(0, slice.size() - 2));
  EXPECT_HAS(error_of([&] { load_volume(folder); }), "'b'");
  // A slice that is cut within its header counts as missing.
  write("b", slice.substr(0, 700));
  EXPECT_HAS(error_of([&] { load_volume(folder); }), "missing");

  const fs::path j2k = series("generic_compressed_j2k/001/IM-0001-0001-0001.dcm");
  const std::string packed = bytes_of(j2k);
  for (const std::size_t size : {packed.size() - 12, packed.size() / 2, packed.size() / 8}) {
    write("cut.dcm", packed.substr(0, size));
    EXPECT_HAS(error_of([&] { load_volume(folder / "cut.dcm"); }), "truncated");
  }
}

/// Loads truncated and damaged versions of a file: each gives an Error or a volume, never a crash.
void expect_no_crash(const std::string& good, const fs::path& folder) {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    std::string bytes = good;
    if (round % 3 == 0) bytes.resize(random() % good.size());
    const std::size_t header = std::min<std::size_t>(bytes.size(), 2000);
    for (int change = 0; change < round % 4 && header > 0; ++change) bytes[random() % header] = char(random());
    std::ofstream(folder / "damaged.dcm", std::ios::binary) << bytes;
    for (const fs::path& path : {folder / "damaged.dcm", folder}) {
      try {
        load_volume(path);
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      }
    }
  }
}

TEST_F(Dicom, DamagedFilesDoNotCrash) {
  REQUIRE_DATA(series(""));
  std::vector<fs::path> files{series("generic_compressed_j2k/001/IM-0001-0001-0001.dcm"),
                              series("siemens_anatomical/001_implicit/IM-0001-0112-0001.dcm")};
  for (const char* name : {"pydicom__MR_small_bigendian.dcm", "pydicom__rtdose_rle.dcm", "pydicom__JPEG-lossy.dcm",
                           "pydicom__SC_rgb_jls_lossy_line.dcm", "pydicom__image_dfl.dcm"}) {
    if (fs::exists(data_folder() / "bad_input" / name)) files.push_back(data_folder() / "bad_input" / name);
  }
  for (const fs::path& file : files) expect_no_crash(bytes_of(file), folder);
}

TEST_F(Dicom, DamagedMultiFrameFilesDoNotCrash) {
  test::EnhancedFile file;
  for (int k = 0; k < 4; ++k) {
    for (int time = 1; time <= 2; ++time)
      file.frames.push_back({.position = {0, 0, 2.0 * k}, .value = 10 * k, .time = time});
  }
  for (const bool explicit_vr : {true, false}) {
    file.explicit_vr = explicit_vr;
    expect_no_crash(file.bytes(), folder);
  }
}

}  // namespace
}  // namespace simplexseg
