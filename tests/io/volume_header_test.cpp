// SPDX-License-Identifier: Apache-2.0
// Labels repeat the geometry fields of the header of their image, so that every program places both alike.
#include <algorithm>
#include <cstdio>
#include <sstream>

#include "core/number_text.h"
#include "image/resample.h"
#include "io/scene/scene_export.h"
#include "io/source/stored_header.h"
#include "session/scene.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::Grid;
using test::odd_volume;
using test::output_of;

constexpr double kTolerance = 1e-4;  ///< mm

/// Geometry fields of a NIfTI-1 file: pixdim[0..3], unit of length, codes, quaternion, offsets, rows.
std::string fields_of(const fs::path& path) {
  const std::string bytes = bytes_of(path);
  return bytes.substr(76, 16) + static_cast<char>(bytes[123] & 7) + bytes.substr(252, 76);
}

NiftiFrame nifti_frame_of(const fs::path& path) {
  const auto header = read_volume_info(path).geometry.header;
  return header ? std::get<NiftiFrame>(header->frame) : NiftiFrame{};
}

class LabelHeader : public test::FolderTest {
 protected:
  /// Writes labels on the grid of an image.
  fs::path write_labels_of(const fs::path& image, const std::string& name) {
    Volume labels(read_volume(image).geometry(), VoxelType::UInt8);
    labels.voxels<std::uint8_t>()[0] = 1;
    write_labels(folder / name, labels);
    return folder / name;
  }

  /// NIfTI images with each pair of codes out of 0, 1, 2 and 4, and with matrices that are equal, apart or sheared, in
  /// mm; and some in other units, versions, byte orders and with a negative qfac.
  std::vector<fs::path> nifti_images() {
    std::vector<fs::path> images;
    const auto add = [&](const std::string& bytes) {
      images.push_back(write("image" + std::to_string(images.size()) + ".nii", bytes));
    };
    const std::string oblique = test::nifti_bytes(folder, odd_volume(VoxelType::Int16));
    const std::string turned = test::nifti_bytes(folder, odd_volume(VoxelType::Int16, Grid::Plain));
    const std::string sheared = test::nifti_bytes(folder, odd_volume(VoxelType::Int16, Grid::Sheared));
    const std::string left = test::nifti_bytes(folder, odd_volume(VoxelType::Int16, Grid::LeftHanded));
    for (const std::string& rows : {oblique, turned, sheared}) {
      for (const int qform : {0, 1, 2, 4}) {
        for (const int sform : {0, 1, 2, 4}) {
          std::string bytes = oblique;
          bytes.replace(280, 48, rows.substr(280, 48));
          if (rows != oblique) test::patch(bytes, 268, 12.25f + 15);
          test::patch(bytes, 252, static_cast<std::int16_t>(qform));
          test::patch(bytes, 254, static_cast<std::int16_t>(sform));
          add(bytes);
        }
      }
    }
    for (const char unit : {'\0', '\1', '\3', '\12'}) {
      std::string bytes = left;
      bytes[123] = unit;
      test::patch(bytes, 254, std::int16_t(unit == '\3' ? 0 : 3));
      add(bytes);
    }
    std::string singular = oblique;  // an sform of zeros beside its code
    std::fill_n(singular.begin() + 280, 48, '\0');
    add(singular);
    std::string mirrored = oblique;
    test::patch(mirrored, 252, std::int32_t(0));
    test::patch(mirrored, 80, -0.5f);
    add(mirrored);
    return images;
  }

  /// Compares images with their labels by the rules of other programs (placement_rules.py).
  void compare(const std::vector<std::pair<fs::path, fs::path>>& pairs, std::size_t rules) {
    if (output_of("/usr/bin/python3 -c 'import nibabel, numpy; print(1)' 2>/dev/null") != "1\n")
      GTEST_SKIP() << "python3-nibabel or -numpy is missing";
    std::string list;
    for (const auto& [image, labels] : pairs) list += image.string() + "\t" + labels.string() + "\n";
    const fs::path script = fs::path(SIMPLEXSEG_SOURCE_DIR) / "tests/io/placement_rules.py";
    std::istringstream output(
        output_of("/usr/bin/python3 '" + script.string() + "' < '" + write("list", list).string() + "' 2>/dev/null"));
    std::size_t count = 0;
    for (std::string rule, number, labels; output >> rule >> number >> labels; ++count) {
      const auto distance = parse_number(number);  // empty for inf and nan
      EXPECT_TRUE(distance && *distance <= kTolerance) << rule << ": " << number << " mm, " << labels;
    }
    EXPECT_EQ(count, pairs.size() * rules);
  }
};

TEST_F(LabelHeader, NiftiFieldsAreRepeatedByteForByte) {
  const std::vector<fs::path> images = nifti_images();
  ASSERT_GE(images.size(), 40u);
  for (const fs::path& image : images) {
    const fs::path labels = write_labels_of(image, "labels.nii");
    EXPECT_EQ(fields_of(labels), fields_of(image)) << image;
    EXPECT_TRUE(read_volume(labels).geometry().same_grid(read_volume(image).geometry(), 1e-9)) << image;
  }
}

TEST_F(LabelHeader, EveryProgramPlacesNiftiLabelsOnTheImage) {
  std::vector<std::pair<fs::path, fs::path>> pairs;
  for (const fs::path& image : nifti_images())
    pairs.emplace_back(image, write_labels_of(image, "labels-" + image.filename().string() + ".gz"));
  compare(pairs, 6);
}

TEST_F(LabelHeader, OtherVersionsAndByteOrdersOfNifti) {
  // NIfTI-2 with numbers that need doubles.
  Volume volume = odd_volume(VoxelType::Int16);
  const fs::path first = folder / "first.nii";
  write_volume(first, volume);
  VolumeGeometry grid = read_volume(first).geometry();
  NiftiFrame frame = nifti_frame_of(first);
  frame.version = 2, frame.qform_code = 4, frame.sform_code = 2;
  frame.srow[3] = -grid.origin_mm[0] + 1e-9, frame.qoffset[2] = 123456.789012345;
  grid.origin_mm[0] -= 1e-9;
  keep_header(grid, frame);
  write_volume(folder / "image.nii", Volume(grid, VoxelType::Int16));
  EXPECT_EQ(bytes_of(folder / "image.nii").substr(4, 3), "n+2");
  EXPECT_EQ(nifti_frame_of(folder / "image.nii"), frame);
  EXPECT_EQ(read_volume_info(folder / "image.nii").format, "NIfTI-2");
  const fs::path labels = write_labels_of(folder / "image.nii", "labels.nii.gz");
  EXPECT_EQ(nifti_frame_of(labels), frame);

  std::string big = test::nifti_bytes(folder, volume);
  test::patch(big, 252, std::int16_t(3));
  const auto swap = [&](std::size_t at, std::size_t count, std::size_t size) {
    for (std::size_t i = 0; i < count; ++i) std::reverse(&big[at + i * size], &big[at + i * size] + size);
  };
  swap(0, 1, 4), swap(40, 8, 2), swap(70, 3, 2), swap(76, 8, 4), swap(108, 3, 4), swap(252, 2, 2), swap(256, 18, 4);
  const fs::path big_labels = write_labels_of(write("big.nii", big), "big-labels.nii");
  EXPECT_EQ(nifti_frame_of(big_labels), nifti_frame_of(folder / "big.nii"));
  EXPECT_EQ(nifti_frame_of(big_labels).qform_code, 3);

  std::string analyze = test::nifti_bytes(folder, volume).substr(0, 252) + std::string(96, '\0');
  test::patch(analyze, 108, 0.0f);  // the voxels begin at the first byte of the .img file
  write("old.hdr", analyze);
  write("old.img", std::string(static_cast<const char*>(volume.data()), volume.bytes()));
  const NiftiFrame old = nifti_frame_of(write_labels_of(folder / "old.hdr", "old-labels.nii"));
  EXPECT_EQ(old.qform_code, 0);
  EXPECT_EQ(old.sform_code, 0);
  EXPECT_EQ(old.pixdim[3], 2.5);
  compare({{folder / "image.nii", labels}, {folder / "big.nii", big_labels}}, 6);
}

TEST_F(LabelHeader, NrrdFieldsAreRepeated) {
  const std::string oblique = "space directions: (2,0.5,0) (-0.25,3,0) (0,0.125,4)\nspace origin: (10,20,30)\n";
  const std::vector<std::vector<std::string>> headers = {
      {"space: right-anterior-superior\n", oblique},
      {"space: RAS\nspace units: \"cm\" \"cm\" \"cm\"\n", oblique},
      {"space: scanner-xyz\n", oblique},
      {"space dimension: 3\n", oblique},
      {"space: left-posterior-superior\nspacings: 0.5 -1 2\nspace origin: (1,2,3)\n"},
      {"# no geometry\n"},
      {"spacings: 0.5 1 -2\naxis mins: 4 5 6\ncenters: node cell ???\nunits: \"cm\" \"cm\" \"cm\"\n"},
      {"space: anterior-superior-left-time\n",
       "space directions: (2,0.5,0,0) (-0.25,3,0,0) (0,0.125,4,0)\nspace origin: (10,20,30,0)\n"}};
  std::vector<std::pair<fs::path, fs::path>> pairs;
  for (const auto& parts : headers) {
    std::string fields;
    for (const std::string& part : parts) fields += part;
    const std::string stem = std::to_string(pairs.size());
    const std::string start = "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 2 3 4\n";
    const fs::path image = write("image" + stem + ".nrrd", start + fields + "encoding: raw\n\n" + std::string(24, 'x'));
    pairs.emplace_back(image, write_labels_of(image, stem + (pairs.empty() ? ".seg.nrrd" : ".nrrd")));
    const std::string labels = bytes_of(pairs.back().second);
    std::string expected = fields.substr(0, fields.find('\n') + 1);
    if (fields.starts_with('#')) expected = "sizes: 2 3 4\nkinds: domain domain domain\n";
    if (expected.ends_with("-time\n")) expected = "space: anterior-superior-left\n";
    EXPECT_HAS(labels, expected);
    const auto a = read_volume_info(image).geometry, b = read_volume_info(pairs.back().second).geometry;
    EXPECT_TRUE(b.same_grid(a, 1e-9)) << fields;
  }
  compare(pairs, 1);
}

TEST_F(LabelHeader, ANrrdFileWithFurtherAxesKeepsThoseOfSpace) {
  const fs::path image = write("image.nrrd",
                               "NRRD0005\ntype: uchar\ndimension: 4\nsizes: 2 2 3 4\nspace: RAS\n"
                               "kinds: list space space space\n"
                               "space directions: none (2,0.5,0) (-0.25,3,0) (0,0.125,4)\n"
                               "space origin: (10,20,30)\nencoding: raw\n\n" +
                                   std::string(48, 'x'));
  const fs::path labels = write_labels_of(image, "labels.nrrd");
  EXPECT_HAS(bytes_of(labels), "space: RAS\nspace directions: (2,0.5,0) (-0.25,3,0) (0,0.125,4)\n");
  compare({{image, labels}}, 1);
}

TEST_F(LabelHeader, MetaImageFieldsAreRepeated) {
  const std::vector<std::string> headers = {
      "AnatomicalOrientation = RAI\nTransformMatrix = 0 1 0 1 0 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 0.5 1 2\n"
      "CenterOfRotation = 4 5 6\n",
      "ElementSpacing = 0.5 1 -2\n", "Offset = 1 2 3\nElementSpacing = 1 1 1\n"};
  std::vector<std::pair<fs::path, fs::path>> pairs;
  for (const std::string& fields : headers) {
    const std::string stem = std::to_string(pairs.size());
    const fs::path image =
        write("image" + stem + ".mha", "ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\n" + fields +
                                           "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + std::string(24, 'x'));
    pairs.emplace_back(image, write_labels_of(image, stem + ".mha"));
    std::istringstream lines(fields);
    for (std::string line; std::getline(lines, line);) EXPECT_HAS(bytes_of(pairs.back().second), line + "\n");
    EXPECT_EQ(bytes_of(pairs.back().second).find("TransformMatrix") != std::string::npos, stem == "0");
  }
  compare(pairs, 1);
}

TEST_F(LabelHeader, AChangedGridIsStatedAsItIs) {
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  test::patch(bytes, 252, std::int16_t(2));
  test::patch(bytes, 254, std::int16_t(4));
  const VolumeGeometry grid = read_volume(write("image.nii", bytes)).geometry();
  for (const int change : {0, 1, 2}) {
    VolumeGeometry changed = grid;
    if (change == 0) changed.origin_mm[1] += 0.01;
    if (change == 1) changed.size[2] -= 1;
    if (change == 2) changed.direction.col(0) *= -1;
    write_labels(folder / "labels.nii", Volume(changed, VoxelType::UInt8));
    EXPECT_TRUE(read_volume(folder / "labels.nii").geometry().same_grid(changed, 1e-4)) << change;
    EXPECT_EQ(nifti_frame_of(folder / "labels.nii").sform_code, 1) << change;
    EXPECT_EQ(nifti_frame_of(folder / "labels.nii").qform_code, 1) << change;
  }
}

TEST_F(LabelHeader, AnotherFormatStatesTheGridInUse) {
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  test::patch(bytes, 268, 1.0f);
  const fs::path image = write("image.nii", bytes);
  const VolumeGeometry grid = read_volume(image).geometry();
  for (const char* name : {"labels.nrrd", "labels.seg.nrrd", "labels.mha"})
    EXPECT_TRUE(read_volume(write_labels_of(image, name)).geometry().same_grid(grid, 1e-9)) << name;
  const fs::path back = write_labels_of(folder / "labels.nrrd", "back.nii");
  EXPECT_EQ(nifti_frame_of(back).qform_code, 1);
  EXPECT_TRUE(read_volume(back).geometry().same_grid(grid, 1e-4));
}

TEST_F(LabelHeader, SavedAndResampledLabelsCarryIt) {
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  test::patch(bytes, 252, std::int16_t(2));
  test::patch(bytes, 254, std::int16_t(4));
  test::patch(bytes, 268, 1.0f);
  const fs::path image = write("image.nii", bytes);
  const Volume volume = read_volume(image);
  EXPECT_EQ(save_labels(folder / "saved.nii", Scene{}, volume.geometry()), "");
  EXPECT_EQ(fields_of(folder / "saved.nii"), fields_of(image));
  write_labels(folder / "resampled.nii",
               resample_labels(odd_volume(VoxelType::UInt8, Grid::Plain), volume.geometry()).labels);
  EXPECT_EQ(fields_of(folder / "resampled.nii"), fields_of(image));
}

TEST_F(LabelHeader, ShearGivesAWarning) {
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    const std::string warning = write_labels(folder / name, odd_volume(VoxelType::UInt8, Grid::Sheared));
    EXPECT_HAS(warning, "degrees from right angles");
    EXPECT_EQ(warning.find("qform") != std::string::npos, std::string(name).starts_with("a.nii")) << name;
    EXPECT_EQ(write_labels(folder / name, odd_volume(VoxelType::UInt8, Grid::LeftHanded)), "") << name;
  }
  EXPECT_EQ(save_labels(folder / "b.nii", Scene{}, test::odd_geometry(Grid::Plain)), "");
  EXPECT_HAS(save_labels(folder / "b.nii", Scene{}, test::odd_geometry(Grid::Sheared)), "ITK");
}

TEST_F(LabelHeader, ASlightlyShearedGridHasNoQformThatDiffersFromItsSform) {
  VolumeGeometry g = test::odd_geometry(Grid::Rotated);
  g.size = {3, 3, 600};
  g.direction.col(2) = (g.direction.col(2) + 4e-5 * g.direction.col(1)).normalized();  // 0.08 voxels at the last slice
  write_volume(folder / "a.nii", Volume(g, VoxelType::UInt8));
  EXPECT_EQ(nifti_frame_of(folder / "a.nii").qform_code, 0);
  EXPECT_EQ(nifti_frame_of(folder / "a.nii").sform_code, 1);
}

TEST_F(LabelHeader, ReportedFiles) {
  REQUIRE_DATA(test::data_folder() / "reports/qs4.nii.gz");
  std::vector<std::pair<fs::path, fs::path>> pairs;
  for (const std::string name : {"qs4.nii.gz", "none.nii.gz"}) {
    const fs::path image = test::data_folder() / "reports" / name;
    pairs.emplace_back(image, write_labels_of(image, name));
    EXPECT_EQ(nifti_frame_of(pairs.back().second), nifti_frame_of(image)) << name;
  }
  EXPECT_EQ(nifti_frame_of(pairs[0].second).qform_code, 1);
  EXPECT_EQ(nifti_frame_of(pairs[0].second).sform_code, 4);
  EXPECT_EQ(nifti_frame_of(pairs[1].second).qform_code, 0);
  EXPECT_EQ(nifti_frame_of(pairs[1].second).sform_code, 0);
  compare(pairs, 6);
}

}  // namespace
}  // namespace simplexseg
