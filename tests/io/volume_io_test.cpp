// SPDX-License-Identifier: Apache-2.0
#include "io/volume/volume_io.h"

#include <cmath>
#include <map>

#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::data_folder;
using test::error_of;
using test::Grid;
using test::odd_volume;
using test::same_voxels;
using test::templates_folder;

struct Region {
  std::size_t count = 0;
  Eigen::Vector3d centre_mm{0, 0, 0};
};

/// Number of voxels and centroid of each label.
std::map<int, Region> regions_of(const Volume& labels) {
  std::map<int, Region> regions;
  const Eigen::Affine3d world_from_index = labels.geometry().world_from_index();
  const auto [ni, nj, nk] = labels.geometry().size;
  for (int k = 0; k < nk; ++k) {
    for (int j = 0; j < nj; ++j) {
      for (int i = 0; i < ni; ++i) {
        const int label = int(labels.value(i, j, k));
        if (label == 0) continue;
        Region& region = regions[label];
        ++region.count;
        region.centre_mm += world_from_index * Eigen::Vector3d(i, j, k);
      }
    }
  }
  for (auto& [label, region] : regions) region.centre_mm /= double(region.count);
  return regions;
}

TEST(RealVolumes, CtKeepsItsTypeGeometryAndValues) {
  const fs::path path = data_folder() / "ct_abdomen/ct.nii.gz";
  REQUIRE_DATA(path);
  const LoadedVolume loaded = load_volume(path);
  EXPECT_EQ(loaded.format, "NIfTI-1");
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_EQ(loaded.volume.type(), VoxelType::Int32);
  const VolumeGeometry& g = loaded.volume.geometry();
  EXPECT_EQ(g.size, (std::array<int, 3>{122, 101, 112}));
  EXPECT_TRUE(g.spacing_mm.isApprox(Eigen::Vector3d(3, 3, 3)));
  // RAS on disk, so i and j run against LPS.
  EXPECT_TRUE(g.direction.isApprox(Eigen::Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix()));
  const Volume labels = read_volume(path.parent_path() / "labels.nii.gz");
  EXPECT_EQ(labels.type(), VoxelType::UInt8);
  EXPECT_TRUE(labels.geometry().same_grid(g));

  const auto regions = regions_of(labels);
  EXPECT_EQ(regions.at(2).count, 7134u);
  EXPECT_EQ(regions.at(3).count, 5090u);
  const double spine = regions.at(29).centre_mm[0];
  EXPECT_LT(regions.at(2).centre_mm[0], spine - 20);  // right kidney: +x is the patient's left
  EXPECT_GT(regions.at(3).centre_mm[0], spine + 20);
  EXPECT_GT(regions.at(27).centre_mm[1], regions.at(21).centre_mm[1]);  // the spine is posterior to the bladder: +y
  EXPECT_GT(regions.at(31).centre_mm[2], regions.at(27).centre_mm[2]);  // L1 above L5

  double bladder = 0;
  const auto ct = loaded.volume.voxels<std::int32_t>();
  const auto mask = labels.voxels<std::uint8_t>();
  for (std::size_t i = 0; i < ct.size(); ++i) bladder += mask[i] == 21 ? ct[i] : 0;
  EXPECT_NEAR(bladder / double(regions.at(21).count), 12, 3);
  EXPECT_GT(loaded.volume.range().max, 3000);  // the metal hip
}

TEST(RealVolumes, InfoNeedsNoVoxels) {
  const fs::path path = data_folder() / "ct_abdomen/ct.nii.gz";
  REQUIRE_DATA(path);
  const VolumeInfo info = read_volume_info(path);
  EXPECT_EQ(info.type, VoxelType::Int32);
  EXPECT_EQ(info.format, "NIfTI-1");
  EXPECT_EQ(info.components, 1);
  EXPECT_EQ(info.frames, 1);
  EXPECT_EQ(info.file_count, 1);
  EXPECT_TRUE(info.geometry.same_grid(read_volume(path).geometry(), 1e-9));
}

TEST(RealVolumes, HippocampiMatchTheirLabels) {
  const fs::path images = data_folder() / "hippocampus/images", labels = data_folder() / "hippocampus/labels";
  REQUIRE_DATA(images);
  std::map<VoxelType, int> types;
  for (const auto& entry : fs::directory_iterator(images)) {
    const Volume image = read_volume(entry.path()), label = read_volume(labels / entry.path().filename());
    ++types[image.type()];
    EXPECT_TRUE(image.geometry().same_grid(label.geometry())) << entry.path();
    EXPECT_EQ(label.range().max, 2) << entry.path();
    EXPECT_GT(image.range().max, 0) << entry.path();
  }
  EXPECT_GT(types[VoxelType::UInt8], 0);
  EXPECT_GT(types[VoxelType::Float32], 0);
  EXPECT_EQ(types.size(), 2u);
}

TEST(RealVolumes, HeadTemplateHasItsSform) {
  REQUIRE_DATA(templates_folder / "ch2bet.nii.gz");
  const LoadedVolume head = load_volume(templates_folder / "ch2.nii.gz");
  const Volume brain = read_volume(templates_folder / "ch2bet.nii.gz");
  EXPECT_EQ(head.volume.type(), VoxelType::UInt8);
  EXPECT_EQ(head.volume.geometry().size, (std::array<int, 3>{181, 217, 181}));
  EXPECT_TRUE(head.volume.geometry().origin_mm.isApprox(Eigen::Vector3d(90, 125, -71)));
  EXPECT_TRUE(head.volume.geometry().same_grid(brain.geometry()));
  std::size_t count = 0;
  for (std::uint8_t v : brain.voxels<std::uint8_t>()) count += v != 0;
  EXPECT_EQ(count, 1737193u);
}

TEST(RealVolumes, AtlasSidesAreThePatients) {
  REQUIRE_DATA(templates_folder / "aal.nii.gz");
  const auto regions = regions_of(read_volume(templates_folder / "aal.nii.gz"));
  EXPECT_EQ(regions.size(), 116u);
  for (const int left : {37, 73, 77}) {  // hippocampus, putamen, thalamus
    EXPECT_GT(regions.at(left).centre_mm[0], 5);
    EXPECT_LT(regions.at(left + 1).centre_mm[0], -5);
  }
}

/// These atlases have a left-handed header and a qform that is mirrored or lacks its offsets. In world coordinates they
/// must overlap the brain of another file.
TEST(RealVolumes, LeftHandedAtlasesLieInTheBrain) {
  REQUIRE_DATA(templates_folder / "ch2bet.nii.gz");
  const Volume brain = read_volume(templates_folder / "ch2bet.nii.gz");
  const Eigen::Affine3d index_from_world = brain.geometry().index_from_world();
  for (const char* name : {"AICHAmc.nii.gz", "HarvardOxford-cort-maxprob-thr0-1mm.nii.gz", "natbrainlab.nii.gz"}) {
    const LoadedVolume atlas = load_volume(templates_folder / name);
    EXPECT_LT(atlas.volume.geometry().direction.determinant(), 0) << name;
    ASSERT_EQ(atlas.warnings.size(), 1u) << name;
    EXPECT_HAS(atlas.warnings[0], "sform");
    const Eigen::Affine3d brain_from_atlas = index_from_world * atlas.volume.geometry().world_from_index();
    const auto [ni, nj, nk] = atlas.volume.geometry().size;
    double inside = 0, all = 0;
    for (int k = 0; k < nk; k += 2) {
      for (int j = 0; j < nj; j += 2) {
        for (int i = 0; i < ni; i += 2) {
          if (atlas.volume.value(i, j, k) == 0) continue;
          const Eigen::Vector3d at = (brain_from_atlas * Eigen::Vector3d(i, j, k)).array().round();
          ++all;
          bool within = true;
          for (int a = 0; a < 3; ++a) within &= at[a] >= 0 && at[a] < brain.geometry().size[a];
          inside += within && brain.value(int(at[0]), int(at[1]), int(at[2])) > 0;
        }
      }
    }
    EXPECT_GT(inside / all, 0.75) << name;
  }
}

class VolumeFile : public test::FolderTest {};

TEST_F(VolumeFile, EveryTypeIsRestoredBitForBit) {
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    for (int t = 0; t < 8; ++t) {
      const Volume volume = odd_volume(static_cast<VoxelType>(t));
      write_volume(folder / name, volume);
      const LoadedVolume read = load_volume(folder / name);
      EXPECT_TRUE(same_voxels(read.volume, volume)) << name << ' ' << to_string(volume.type());
      EXPECT_TRUE(read.warnings.empty()) << name << ' ' << read.warnings[0];
    }
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 4);  // no temporary files remain
}

TEST_F(VolumeFile, EveryGeometryIsRestored) {
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
    for (const Grid grid : {Grid::Plain, Grid::Rotated, Grid::LeftHanded, Grid::Sheared}) {
      const Volume volume = odd_volume(VoxelType::UInt8, grid);
      write_labels(folder / name, volume);
      const LoadedVolume read = load_volume(folder / name);
      const double tolerance = std::string(name).starts_with("a.nii") ? 1e-5 : 1e-9;  // NIfTI stores floats
      const auto a = read.volume.geometry().world_from_index(), b = volume.geometry().world_from_index();
      EXPECT_TRUE(a.isApprox(b, tolerance)) << name << int(grid) << '\n' << a.matrix() << '\n' << b.matrix();
      EXPECT_EQ(read.warnings.size(), grid == Grid::Sheared ? 1u : 0u) << name << int(grid);
    }
  }
}

TEST_F(VolumeFile, ExtensionsAreNotCaseSensitive) {
  const Volume volume = odd_volume(VoxelType::Int16);
  write_volume(folder / "a.NII.GZ", volume);
  EXPECT_EQ(bytes_of(folder / "a.NII.GZ").substr(0, 2), "\x1f\x8b");
  EXPECT_TRUE(same_voxels(read_volume(folder / "a.NII.GZ"), volume));
}

TEST_F(VolumeFile, InvalidTargetsAndVolumesAreRejected) {
  const Volume volume = odd_volume(VoxelType::Int16);
  EXPECT_HAS(error_of([&] { write_volume(folder / "none" / "a.nii.gz", volume); }), "does not exist");
  EXPECT_HAS(error_of([&] { write_volume(folder / "a.png", volume); }), ".nii.gz");
  error_of([&] { write_volume(folder / "a.mhd", volume); });
  error_of([&] { write_volume(folder / "a", volume); });
  error_of([&] { write_volume(folder, volume); });
  EXPECT_HAS(error_of([&] { write_volume(folder / "a.nii", Volume()); }), "empty");
  EXPECT_HAS(error_of([&] { write_labels(folder / "a.nii", odd_volume(VoxelType::Float32)); }), "integers");
  VolumeGeometry long_one;
  long_one.size = {40000, 1, 1};
  EXPECT_HAS(error_of([&] { write_volume(folder / "a.nii", Volume(long_one, VoxelType::UInt8)); }), "32767");
  EXPECT_TRUE(fs::is_empty(folder));
  write_volume(folder / "a.nrrd", Volume(long_one, VoxelType::UInt8));
  EXPECT_EQ(read_volume(folder / "a.nrrd").geometry().size[0], 40000);
}

/// After a failed write the old file must be unchanged.
TEST_F(VolumeFile, AFailedWriteKeepsTheOldFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const Volume volume = odd_volume(VoxelType::Int16);
  write_volume(folder / "a.nii", volume);
  const std::string before = bytes_of(folder / "a.nii");
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  if (std::ofstream(folder / "probe")) {
    fs::permissions(folder, fs::perms::owner_all);
    GTEST_SKIP() << "this user may write everywhere";
  }
  error_of([&] { write_volume(folder / "a.nii", volume); });
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_EQ(bytes_of(folder / "a.nii"), before);
}

TEST_F(VolumeFile, ALinkIsKept) {
  const Volume volume = odd_volume(VoxelType::Int16);
  fs::create_directory(folder / "elsewhere");
  write("elsewhere/real.nii", "old");
  fs::create_symlink(folder / "elsewhere/real.nii", folder / "link.nii");
  write_volume(folder / "link.nii", volume);
  EXPECT_TRUE(fs::is_symlink(folder / "link.nii"));
  EXPECT_TRUE(same_voxels(read_volume(folder / "elsewhere/real.nii"), volume));
}

TEST_F(VolumeFile, ScaledNiftiBecomesFloat) {
  const Volume volume = odd_volume(VoxelType::Int16);
  std::string bytes = test::nifti_bytes(folder, volume);
  test::patch(bytes, 112, 0.5f);
  test::patch(bytes, 116, -3.0f);
  const Volume scaled = read_volume(write("scaled.nii", bytes));
  ASSERT_EQ(scaled.type(), VoxelType::Float32);
  for (std::size_t i = 0; i < volume.voxels<std::int16_t>().size(); ++i) {
    EXPECT_EQ(scaled.voxels<float>()[i], 0.5f * volume.voxels<std::int16_t>()[i] - 3);
  }
  test::patch(bytes, 112, 0.0f);  // slope 0: no scaling
  EXPECT_TRUE(same_voxels(read_volume(write("scaled.nii", bytes)), volume));
}

TEST_F(VolumeFile, BigEndianNiftiIsSwapped) {
  const Volume volume = odd_volume(VoxelType::Float32);
  std::string bytes = test::nifti_bytes(folder, volume);
  const auto swap = [&](std::size_t at, std::size_t count, std::size_t size) {
    for (std::size_t i = 0; i < count; ++i) std::reverse(&bytes[at + i * size], &bytes[at + i * size] + size);
  };
  swap(0, 1, 4), swap(40, 8, 2), swap(70, 3, 2), swap(76, 8, 4), swap(108, 3, 4), swap(252, 2, 2), swap(256, 18, 4);
  swap(352, volume.geometry().voxel_count(), 4);
  const Volume read = read_volume(write("big.nii", bytes));
  EXPECT_TRUE(same_voxels(read, volume));
  EXPECT_TRUE(read.geometry().same_grid(volume.geometry(), 1e-4));
}

TEST_F(VolumeFile, QformGivesTheSameGridAsSform) {
  for (const Grid grid : {Grid::Plain, Grid::Rotated, Grid::LeftHanded}) {
    const Volume volume = odd_volume(VoxelType::UInt8, grid);
    std::string bytes = test::nifti_bytes(folder, volume);
    test::patch(bytes, 254, std::int16_t(0));
    const LoadedVolume read = load_volume(write("q.nii", bytes));
    EXPECT_TRUE(read.volume.geometry().same_grid(volume.geometry(), 1e-4)) << int(grid);
    EXPECT_TRUE(read.warnings.empty());
  }
}

TEST_F(VolumeFile, MissingGeometryGivesAWarning) {
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  std::string none = bytes;
  test::patch(none, 252, std::int32_t(0));
  LoadedVolume read = load_volume(write("none.nii", none));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_HAS(read.warnings[0], "orientation");
  EXPECT_TRUE(read.volume.geometry().spacing_mm.isApprox(Eigen::Vector3d(0.5, 0.75, 2.5)));

  std::string moved = bytes;  // an sform 20 mm from the qform
  test::patch(moved, 280 + 12, 20 + 12.25f);
  read = load_volume(write("moved.nii", moved));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_HAS(read.warnings[0], "20 mm apart");
  EXPECT_NEAR(read.volume.geometry().origin_mm[0], -32.25, 1e-4);

  std::string singular = bytes;  // a singular sform and a valid qform
  for (int i = 0; i < 12; ++i) test::patch(singular, 280 + 4 * i, 0.0f);
  read = load_volume(write("singular.nii", singular));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_TRUE(read.volume.geometry().same_grid(test::odd_geometry(Grid::Rotated), 1e-4));

  std::string metres = bytes;
  metres[123] = 1;
  read = load_volume(write("metres.nii", metres));
  EXPECT_NEAR(read.volume.geometry().spacing_mm[0], 500, 1e-3);
}

TEST_F(VolumeFile, NegativeVoxelSizesAreDirections) {
  const Volume volume = odd_volume(VoxelType::UInt8, Grid::Plain);
  const std::string raw(static_cast<const char*>(volume.data()), volume.bytes());
  std::string none = test::nifti_bytes(folder, volume);
  test::patch(none, 252, std::int32_t(0));
  test::patch(none, 80, -0.5f);
  std::string analyze = none.substr(0, 252) + std::string(96, '\0');
  test::patch(analyze, 108, 0.0f);  // the voxels begin at the first byte of the .img file
  write("old.img", raw);
  std::string gipl(256, '\0');
  const auto put = [&](std::size_t at, auto value) {
    test::patch(gipl, at, value);
    std::reverse(gipl.begin() + static_cast<long>(at), gipl.begin() + static_cast<long>(at + sizeof value));
  };
  for (int a = 0; a < 3; ++a) {
    put(2 * a, static_cast<std::uint16_t>(volume.geometry().size[a]));
    put(10 + 4 * a, (a == 0 ? -1 : 1) * static_cast<float>(volume.geometry().spacing_mm[a]));
  }
  put(8, std::uint16_t(8)), put(252, std::uint32_t(719555000));
  const fs::path paths[] = {
      write("none.nii", none), write("old.hdr", analyze), write("a.gipl", gipl + raw),
      write("a.mha",
            "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = -0.5 0.75 2.5\nElementType = MET_UCHAR\n"
            "ElementDataFile = LOCAL\n" +
                raw),
      write("a.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5 4 3\nspacings: -0.5 0.75 2.5\nencoding: raw\n\n" + raw)};
  for (const fs::path& path : paths) {
    const VolumeGeometry g = read_volume(path).geometry();
    EXPECT_TRUE(g.spacing_mm.isApprox(Eigen::Vector3d(0.5, 0.75, 2.5), 1e-6)) << path;
    EXPECT_EQ(g.direction, Eigen::Matrix3d(Eigen::Vector3d(-1, 1, 1).asDiagonal())) << path;
    EXPECT_EQ(g.origin_mm, Eigen::Vector3d(0, 0, 0)) << path;
  }
  // The standard allows positive sizes only beside a qform.
  std::string qform = test::nifti_bytes(folder, volume);
  test::patch(qform, 254, std::int16_t(0));
  test::patch(qform, 80, -0.5f);
  const LoadedVolume read = load_volume(write("qform.nii", qform));
  EXPECT_TRUE(read.volume.geometry().same_grid(volume.geometry(), 1e-4));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_HAS(read.warnings[0], "axis 1 is negative");
}

TEST_F(VolumeFile, SmallShiftsAreStatedInMicrometres) {
  VolumeGeometry g;
  g.size = {5, 4, 3};
  g.spacing_mm.setConstant(0.008);
  std::string bytes = test::nifti_bytes(folder, Volume(g, VoxelType::UInt8));
  test::patch(bytes, 280 + 12, 0.004f);
  const LoadedVolume micro = load_volume(write("micro.nii", bytes));
  ASSERT_EQ(micro.warnings.size(), 1u);
  EXPECT_HAS(micro.warnings[0], "up to 4 \u00b5m apart");
}

TEST_F(VolumeFile, WideIntegersAreNarrowedWhereTheyFit) {
  const Volume volume = odd_volume(VoxelType::Int32);
  std::string bytes = test::nifti_bytes(folder, volume).substr(0, 352);
  test::patch(bytes, 70, std::int16_t(1024));
  test::patch(bytes, 72, std::int16_t(64));
  for (std::int32_t v : volume.voxels<std::int32_t>()) {
    bytes.resize(bytes.size() + 8);
    test::patch(bytes, bytes.size() - 8, std::int64_t(v));
  }
  const LoadedVolume read = load_volume(write("wide.nii", bytes));
  EXPECT_TRUE(same_voxels(read.volume, volume));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_HAS(read.warnings[0], "64-bit");
  test::patch(bytes, 352 + 8 * 10, std::int64_t(1) << 40);
  EXPECT_HAS(error_of([&] { load_volume(write("wide.nii", bytes)); }), "1099511627776");

  const std::string nrrd = "NRRD0004\ntype: uint64\ndimension: 3\nsizes: 2 1 1\nendian: little\nencoding: raw\n\n";
  std::string voxels(16, '\0');
  test::patch(voxels, 8, std::uint64_t(4000000000));
  const Volume wide = read_volume(write("wide.nrrd", nrrd + voxels));
  ASSERT_EQ(wide.type(), VoxelType::UInt32);
  EXPECT_EQ(wide.voxels<std::uint32_t>()[1], 4000000000u);
  test::patch(voxels, 8, std::uint64_t(5000000000));
  EXPECT_HAS(error_of([&] { load_volume(write("wide.nrrd", nrrd + voxels)); }), "5000000000");
}

TEST_F(VolumeFile, OneSliceAndATrailingAxisOfOneAreVolumes) {
  std::string bytes = test::nifti_bytes(folder, odd_volume(VoxelType::UInt8));
  std::string four = bytes;
  test::patch(four, 40, std::int16_t(4));
  EXPECT_EQ(read_volume(write("four.nii", four)).geometry().size, (std::array<int, 3>{5, 4, 3}));
  test::patch(four, 48, std::int16_t(2));
  four += four.substr(352);
  EXPECT_EQ(read_volume_info(write("four.nii", four)).frames, 2);
  std::string two = bytes;
  test::patch(two, 40, std::int16_t(2));
  EXPECT_EQ(read_volume(write("two.nii", two)).geometry().size, (std::array<int, 3>{5, 4, 1}));
  const Volume flat = read_volume(write(
      "two.nrrd", "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 3 2\nspacings: 0.5 0.25\nencoding: raw\n\nabcdef"));
  EXPECT_EQ(flat.geometry().size, (std::array<int, 3>{3, 2, 1}));
  EXPECT_EQ(flat.value(2, 1, 0), 'f');
  EXPECT_TRUE(flat.geometry().spacing_mm.isApprox(Eigen::Vector3d(0.5, 0.25, 1)));
}

TEST_F(VolumeFile, NrrdInRasIsConvertedToLps) {
  const Volume v =
      read_volume(write("ras.nrrd",
                        "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 2 1 1\n"
                        "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\nencoding: raw\n\nab"));
  EXPECT_TRUE((v.geometry().world_from_index() * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(-12, -20, 30)));
}

TEST_F(VolumeFile, PairsAndAnalyzeAreRead) {
  const Volume volume = odd_volume(VoxelType::Int16);
  const std::string bytes = test::nifti_bytes(folder, volume);
  std::string header = bytes.substr(0, 348);
  header.replace(344, 4, std::string("ni1\0", 4));
  test::patch(header, 108, 0.0f);
  write("pair.hdr", header);
  write("pair.img", bytes.substr(352));
  for (const char* name : {"pair.hdr", "pair.img"}) {
    const VolumeInfo info = read_volume_info(folder / name);
    EXPECT_EQ(info.file_count, 2);
    EXPECT_EQ(info.format, "NIfTI-1");
    const Volume read = read_volume(folder / name);
    EXPECT_TRUE(same_voxels(read, volume));
    EXPECT_TRUE(read.geometry().same_grid(volume.geometry(), 1e-4));
  }
  write("old.hdr", header.substr(0, 252) + std::string(96, '\0'));
  write("old.img", bytes.substr(352));
  const LoadedVolume analyze = load_volume(folder / "old.hdr");
  EXPECT_EQ(analyze.format, "Analyze 7.5");
  EXPECT_TRUE(same_voxels(analyze.volume, volume));
  EXPECT_EQ(analyze.warnings.size(), 1u);
  write("short.hdr", header);
  EXPECT_HAS(error_of([&] { load_volume(folder / "short.hdr"); }), "its voxel file");
  write("short.img", bytes.substr(352, 50));
  EXPECT_HAS(error_of([&] { load_volume(folder / "short.hdr"); }), "truncated");
  write("lone.img", bytes.substr(352));
  EXPECT_HAS(error_of([&] { load_volume(folder / "lone.img"); }), "header");
}

TEST_F(VolumeFile, MincIsConvertedToLps) {
  // minc2_1_scale's affine is diag(2, 2, 2) with origin (-20, -20, -10) in RAS (nibabel's tests).
  const fs::path path = data_folder() / "bad_input/nibabel__minc2_1_scale.mnc";
  REQUIRE_DATA(path);
  const Volume v = read_volume(path);
  EXPECT_EQ(v.geometry().size, (std::array<int, 3>{20, 20, 10}));
  EXPECT_TRUE((v.geometry().world_from_index() * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(18, 20, -10)));
  EXPECT_NEAR(v.range().min, 0.20828, 1e-5);  // reference value of nibabel: min 0.2082842439
  EXPECT_NEAR(v.range().max, 0.20943, 1e-5);
}

TEST_F(VolumeFile, VoxelsThatAreNotFiniteAreCounted) {
  Volume volume = odd_volume(VoxelType::Float32);
  volume.voxels<float>()[7] = std::numeric_limits<float>::quiet_NaN();
  volume.voxels<float>()[9] = std::numeric_limits<float>::infinity();
  write_volume(folder / "nan.nii.gz", volume);
  const LoadedVolume read = load_volume(folder / "nan.nii.gz");
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_HAS(read.warnings[0], "2 voxels");
}

}  // namespace
}  // namespace simplexseg
