// SPDX-License-Identifier: Apache-2.0
// Files that cannot be loaded: each gives an Error of one line.
#include <fcntl.h>
#include <unistd.h>

#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::data_folder;
using test::error_of;
using test::odd_volume;

class VolumeErrors : public test::FolderTest {
 protected:
  std::string load(const std::string& name) {
    return error_of([&] { load_volume(folder / name); });
  }
};

TEST_F(VolumeErrors, PathsThatAreNotVolumes) {
  EXPECT_HAS(load("none.nii.gz"), "no such file");
  EXPECT_HAS(load("."), "no DICOM images");
  fs::create_directory(folder / "deeper");
  EXPECT_HAS(load("."), "subfolders");
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha", "a.mnc", "a.dcm", "a", "a.hdr"}) {
    write(name, "");
    EXPECT_HAS(load(name), "empty");
    write(name, "This is a letter,\nnot a volume.\n");
    EXPECT_HAS(load(name), name);
    write(name, std::string(5000, 'x'));
    EXPECT_HAS(load(name), name);
  }
  EXPECT_HAS(load("a"), "format is not supported");
  error_of([&] { load_volume(""); });
  error_of([&] { load_volume("/dev/null"); });
  write("two\nlines.nii", "x");
  load("two\nlines.nii");
}

TEST_F(VolumeErrors, NiftiTruncatedAnywhere) {
  const std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::Int16));
  test::write_gzip(folder / "whole.nii.gz", bytes);
  const std::string packed = bytes_of(folder / "whole.nii.gz");
  load_volume(folder / "whole.nii.gz");
  for (std::size_t size = 1; size < bytes.size(); size += size < 360 ? 7 : 1) {
    write("cut.nii", bytes.substr(0, size));
    EXPECT_HAS(load("cut.nii"), size < 348 ? "NIfTI header" : "truncated");
    // The compressed file is complete, but its content is truncated; ITK's reader would pad it with zeros.
    test::write_gzip(folder / "short.nii.gz", bytes.substr(0, size));
    EXPECT_HAS(load("short.nii.gz"), size < 348 ? "NIfTI header" : "truncated");
  }
  for (std::size_t size = 1; size < packed.size(); ++size) {
    write("cut.nii.gz", packed.substr(0, size));
    load("cut.nii.gz");
  }
  std::string wrong = packed;
  wrong[wrong.size() - 7] ^= 1;  // the checksum
  write("wrong.nii.gz", wrong);
  EXPECT_HAS(load("wrong.nii.gz"), "damaged");
}

TEST_F(VolumeErrors, RealCtTruncatedInHalf) {
  const fs::path path = data_folder() / "ct_abdomen/ct.nii.gz";
  REQUIRE_DATA(path);
  const std::string bytes = bytes_of(path);
  write("half.nii.gz", bytes.substr(0, bytes.size() / 2));
  EXPECT_HAS(load("half.nii.gz"), "truncated");
  std::string wrong = bytes;
  wrong[wrong.size() - 7] ^= 1;
  write("wrong.nii.gz", wrong);
  EXPECT_HAS(load("wrong.nii.gz"), "its compressed data is damaged");
}

TEST_F(VolumeErrors, OtherFormatsTruncated) {
  Volume volume = odd_volume(VoxelType::Int16);
  for (const char* name : {"a.nrrd", "a.mha"}) {
    write_volume(folder / name, volume);
    const std::string bytes = bytes_of(folder / name);
    for (std::size_t size : {bytes.size() / 4, bytes.size() / 2, bytes.size() - 40, bytes.size() - 20}) {
      const std::string cut = std::string("cut-") + name;
      write(cut, bytes.substr(0, size));
      load(cut);
    }
  }
  // Uncompressed; the header announces 60 voxels, the file has 59.
  const std::string voxels(118, 'v');
  write("raw.nrrd", "NRRD0004\ntype: int16\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: raw\n\n" + voxels);
  load("raw.nrrd");
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\nElementDataFile = ";
  write("raw.mha", meta + "LOCAL\n" + voxels);
  load("raw.mha");
  write("raw.mhd", meta + "a.raw\n");
  load("raw.mhd");  // no a.raw
  write("a.raw", voxels);
  load("raw.mhd");
  write("a.raw", voxels + "vv");
  EXPECT_EQ(read_volume(folder / "raw.mhd").value(4, 3, 2), 'v' * 257);
}

TEST_F(VolumeErrors, MincTruncated) {
  const fs::path path = data_folder() / "bad_input/nibabel__minc2_1_scale.mnc";
  REQUIRE_DATA(path);
  const std::string bytes = bytes_of(path);
  for (int part = 1; part < 16; ++part) {
    write("cut.mnc", bytes.substr(0, bytes.size() * part / 16));
    load("cut.mnc");
  }
}

TEST_F(VolumeErrors, InvalidGeometry) {
  const std::string good = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  std::string bytes = good;
  test::patch(bytes, 252, std::int32_t(0));
  test::patch(bytes, 84, std::numeric_limits<float>::infinity());
  write("spacing.nii", bytes);
  EXPECT_HAS(load("spacing.nii"), "spacing");
  for (const std::int16_t size : {std::int16_t(0), std::int16_t(-5)}) {
    bytes = good;
    test::patch(bytes, 44, size);
    write("size.nii", bytes);
    load("size.nii");
  }
  bytes = good;
  test::patch(bytes, 40, std::int16_t(9));
  write("rank.nii", bytes);
  load("rank.nii");
  const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 1 1\n";
  write("singular.nrrd", nrrd + "space directions: (1,0,0) (1,0,0) (0,0,1)\nencoding: raw\n\nab");
  load("singular.nrrd");
  write("nan.nrrd", nrrd + "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,inf)\nencoding: raw\n\nab");
  load("nan.nrrd");
  write("sheared.nrrd", nrrd + "space directions: (1,0,0) (0.5,1,0) (0,0,1)\nencoding: raw\n\nab");
  const LoadedVolume sheared = load_volume(folder / "sheared.nrrd");
  ASSERT_EQ(sheared.warnings.size(), 1u);
  EXPECT_TRUE(
      (sheared.volume.geometry().world_from_index() * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0.5, 1, 0)));
}

TEST_F(VolumeErrors, VoxelsThatAreNotNumbers) {
  const std::string good = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  const std::pair<int, const char*> types[] = {
      {128, "colours"}, {32, "complex"}, {1, "bits"}, {1536, "128"}, {77, "known"}};
  for (const auto& [type, word] : types) {
    std::string bytes = good;
    test::patch(bytes, 70, std::int16_t(type));
    write("type.nii", bytes);
    EXPECT_HAS(load("type.nii"), word);
  }
  write("rgb.mha",
        "ObjectType = Image\nNDims = 3\nDimSize = 2 1 1\nElementNumberOfChannels = 3\nElementType = MET_UCHAR\n"
        "ElementDataFile = LOCAL\nabcdef");
  EXPECT_HAS(load("rgb.mha"), "3 values");
}

TEST_F(VolumeErrors, NumbersThatAreNotWhole) {
  for (const std::string number : {"0,5", "1.0abc", "1e", "0x1", "1.5.2", "--1"}) {
    const auto meta = [&](const char* key) {
      std::string header = "ObjectType = Image\nNDims = 3\n";
      header += std::string("DimSize = 1 1 ") + (std::string("DimSize") == key ? number : "2") + "\n";
      if (std::string("DimSize") != key) header += std::string(key) + " = 1 1 " + number + "\n";
      write("a.mha", header + "ElementType = MET_UCHAR\nElementDataFile = LOCAL\nab");
      EXPECT_HAS(load("a.mha"), key) << number;
      EXPECT_HAS(load("a.mha"), number);
    };
    for (const char* key : {"ElementSpacing", "Offset", "DimSize"}) meta(key);
    const auto nrrd = [&](const char* field, const std::string& value) {
      const std::string sizes = std::string("sizes") == field ? "" : "sizes: 1 1 2\n";
      write("a.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\n" + sizes + field + ": " + value + "\nencoding: raw\n\nab");
      EXPECT_HAS(load("a.nrrd"), field) << value;
      EXPECT_HAS(load("a.nrrd"), number);
    };
    nrrd("spacings", "1 1 " + number);
    nrrd("sizes", "1 1 " + number);
    nrrd("space directions", "(1,0,0) (0,1,0) (0,0," + number + ")");
  }
  // A digit more than any number needs does not begin another voxel.
  const std::string long_number = "0." + std::string(70, '1'), too_long(5000, '1');
  const std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 2\nspacings: 1 1 1\nencoding: text\n\n";
  write("a.nrrd", text + long_number + " 2\n");
  EXPECT_EQ(read_volume(folder / "a.nrrd").value(0, 0, 1), 2);
  write("a.nrrd", text + too_long + " 2\n");
  EXPECT_HAS(load("a.nrrd"), "not a number");
}

/// A sparse file larger than any memory; no memory may be allocated for it.
TEST_F(VolumeErrors, AVolumeLargerThanTheMemoryIsRejected) {
  ASSERT_GT(available_memory(), std::size_t(1) << 20);
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::Float64));
  for (int a = 0; a < 3; ++a) test::patch(bytes, 42 + 2 * a, std::int16_t(a < 2 ? 30000 : 1000));
  write("huge.nii", bytes);
  EXPECT_HAS(load("huge.nii"), "truncated");
  std::error_code error;
  fs::resize_file(folder / "huge.nii", 352 + 8ull * 30000 * 30000 * 1000, error);
  if (error) GTEST_SKIP() << "no sparse files";
  const std::string text = load("huge.nii");
  EXPECT_HAS(text, "7.2 TB");
  EXPECT_HAS(text, "available");
  EXPECT_EQ(read_volume_info(folder / "huge.nii").geometry.size[0], 30000);
}

TEST_F(VolumeErrors, ACompressedHeaderThatAnnouncesTooManyVoxels) {
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::Float64));
  for (int a = 0; a < 3; ++a) test::patch(bytes, 42 + 2 * a, std::int16_t(32767));
  test::write_gzip(folder / "huge.nii.gz", bytes);
  EXPECT_HAS(load("huge.nii.gz"), "truncated");
}

/// Every unusual file loads or throws Error; nothing is printed.
TEST_F(VolumeErrors, UnusualFilesLoadOrThrowWithoutOutput) {
  const fs::path bad = data_folder() / "bad_input";
  REQUIRE_DATA(bad);
  const int kept[2] = {::dup(1), ::dup(2)};
  const fs::path printed = folder / "printed";
  const int file = ::open(printed.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::fflush(stdout);
  ::dup2(file, 1);
  ::dup2(file, 2);
  int loaded = 0, rejected = 0;
  std::string problems;
  for (const auto& entry : fs::directory_iterator(bad)) {
    for (const bool voxels : {false, true}) {
      try {
        if (voxels) {
          const LoadedVolume volume = load_volume(entry.path());
          volume.volume.geometry().validate("volume");
          ++loaded;
        } else {
          read_volume_info(entry.path()).geometry.validate("info");
        }
      } catch (const Error& error) {
        rejected += voxels;
        const std::string text = error.what();
        if (text.find('\n') != std::string::npos || text.find(entry.path().filename()) == std::string::npos)
          problems += text + "\n";
      } catch (const std::exception& exception) {
        problems += entry.path().string() + ": another exception: " + exception.what() + "\n";
      }
    }
  }
  std::fflush(stdout);
  std::fflush(stderr);
  for (int i = 0; i < 2; ++i) {
    ::dup2(kept[i], i + 1);
    ::close(kept[i]);
  }
  ::close(file);
  EXPECT_EQ(problems, "");
  EXPECT_EQ(bytes_of(printed), "");
  EXPECT_GT(loaded, 30);
  EXPECT_GT(rejected, 60);
  EXPECT_EQ(loaded + rejected, std::distance(fs::directory_iterator(bad), {}));
}

TEST_F(VolumeErrors, KnownUnusualFiles) {
  const fs::path bad = data_folder() / "bad_input";
  REQUIRE_DATA(bad);
  const auto load = [&](const char* name) { return error_of([&] { load_volume(bad / name); }); };
  EXPECT_HAS(load("pydicom__MR_truncated.dcm"), "truncated");
  EXPECT_HAS(load("pydicom__examples_rgb_color.dcm"), "3 values");
  EXPECT_HAS(load("pydicom__rtstruct.dcm"), "rtstruct");
  EXPECT_HAS(load("pydicom__waveform_ecg.dcm"), "no image");
  EXPECT_EQ(count_volumes(bad / "nibabel__functional.nii"), 20);
  EXPECT_EQ(load_volume(bad / "nibabel__example_nifti2.nii.gz", 2).frame, 2);
  EXPECT_EQ(read_volume(bad / "nibabel__nicom__philips_mprage.dcm.gz").geometry().size,
            (std::array<int, 3>{256, 256, 176}));
  load("pydicom__dicomdirtests__DICOMDIR-nooffset");  // violates an assertion of GDCM
  const Volume little = read_volume(bad / "pydicom__MR_small.dcm"),
               big = read_volume(bad / "pydicom__MR_small_bigendian.dcm");
  EXPECT_TRUE(test::same_voxels(little, big));
  EXPECT_TRUE(test::same_voxels(little, read_volume(bad / "pydicom__MR_small_implicit.dcm")));
  EXPECT_EQ(little.geometry().size, (std::array<int, 3>{64, 64, 1}));
  EXPECT_EQ(little.value(0, 0, 0), 905);  // reference value of pydicom
  const VolumeInfo nifti2 = read_volume_info(bad / "nibabel__example_nifti2.nii.gz");
  EXPECT_EQ(nifti2.format, "NIfTI-2");
  EXPECT_EQ(nifti2.frames, 2);
  EXPECT_EQ(nifti2.type, VoxelType::Int16);
  // nibabel's tests: the affine's last column is (117.8551, -35.7229, -7.2488) in RAS.
  EXPECT_TRUE(nifti2.geometry.origin_mm.isApprox(Eigen::Vector3d(-117.8551, 35.72294, -7.248798), 1e-5));
}

}  // namespace
}  // namespace simplexseg
