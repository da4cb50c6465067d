// SPDX-License-Identifier: Apache-2.0
// Search for series in folders, on discs and among files; loading of damaged series.
#include "io/dicom/dicom_series.h"

#include <algorithm>

#include "dicom_slices.h"
#include "io/platform/load_progress.h"
#include "io/scene/load_input.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "step/simulation_parameters.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::CtSlice;
using test::error_of;
using test::write_series;

class SeriesTest : public test::FolderTest {
 protected:
  static const DicomSeries& named(const FoundSeries& found, const std::string& name) {
    const auto at = std::find_if(found.series.begin(), found.series.end(),
                                 [&](const DicomSeries& series) { return series.texts.series == name; });
    if (at == found.series.end()) throw std::runtime_error("no series " + name);
    return *at;
  }
};

TEST_F(SeriesTest, AllSeriesBelowAFolderAreFoundWithTheirTexts) {
  write_series(folder / "a" / "one", {}, 4);
  write_series(folder / "b", {.series = "1.2.3.2", .name = "scout"}, 2);
  write_series(folder / "b", {.series = "1.2.3.3", .name = "bone", .columns = 200, .rows = 100}, 3);
  write("readme.txt", "no DICOM");
  const FoundSeries found = find_dicom_series({folder});
  ASSERT_EQ(found.series.size(), 3u);
  EXPECT_TRUE(found.unreadable.empty());
  const DicomSeries& chest = named(found, "chest");
  EXPECT_EQ(chest.texts.patient, "Doe, Jane");
  EXPECT_EQ(chest.texts.patient_id, "P-17");
  EXPECT_EQ(chest.texts.study, "follow-up");
  EXPECT_EQ(chest.texts.date, "2024-05-31");
  EXPECT_EQ(chest.texts.modality, "CT");
  EXPECT_EQ(chest.files, 4);
  EXPECT_EQ(chest.geometry.size, (std::array<int, 3>{6, 5, 4}));
  EXPECT_TRUE(chest.geometry.spacing_mm.isApprox(Eigen::Vector3d(0.75, 0.5, 2)));
  EXPECT_EQ(chest.folder, folder / "a" / "one");
  EXPECT_TRUE(chest.is_only_series);
  EXPECT_TRUE(!chest.damaged && chest.load_error.empty());
  EXPECT_FALSE(named(found, "bone").is_only_series);
  // Middle slice at reduced size.
  const Volume& preview = named(found, "bone").preview;
  EXPECT_EQ(preview.geometry().size, (std::array<int, 3>{100, 50, 1}));
  EXPECT_EQ(preview.value(3, 2, 0), 101 + 10 * 4 + 6);
}

TEST_F(SeriesTest, ASeriesIsOpenedByUidAlsoFromASavedScene) {
  write_series(folder / "both", {}, 5);
  write_series(folder / "both", {.series = "1.2.3.2", .name = "small"}, 3);
  LoadedInput input = load_input(folder / "both", 1, "1.2.3.2");
  EXPECT_EQ(input.volume.geometry().size[2], 3);
  EXPECT_EQ(input.patient, "Doe, Jane");
  EXPECT_EQ(input.series, "small");
  input.scene.simulation = default_simulation_parameters();
  write_scene(folder / "scene.json", input.scene);
  EXPECT_EQ(load_input(folder / "scene.json").volume.geometry().size[2], 3);
  EXPECT_EQ(load_input(folder / "both").volume.geometry().size[2], 5);
  // In subfolders too.
  EXPECT_EQ(load_volume(folder, 1, "1.2.3.2").volume.geometry().size[2], 3);
  EXPECT_NE(error_of([&] { load_volume(folder, 1, "1.2.3.9"); }).find("1.2.3.9"), std::string::npos);
}

TEST_F(SeriesTest, ImagesThatDoNotBelongToTheVolumeAreOmittedHoweverItIsOpened) {
  write_series(folder, {}, 10);
  write("again", test::bytes_of(folder / "chest2"));  // copy
  CtSlice{.z_mm = 40, .columns = 7}.write(folder / "wide");
  CtSlice{.z_mm = 60, .sagittal = true}.write(folder / "sagittal");
  fs::resize_file(folder / "chest0", fs::file_size(folder / "chest0") - 20);
  const FoundSeries found = find_dicom_series({folder});
  ASSERT_EQ(found.series.size(), 1u);
  const DicomSeries& series = found.series.front();
  EXPECT_TRUE(series.damaged);
  EXPECT_EQ(series.load_error, "");
  ASSERT_FALSE(series.warnings.empty());
  for (const char* part : {"only 9 of 13", "unreadable: truncated", "chest0", "chest2", "wide", "sagittal"})
    EXPECT_HAS(series.warnings.front(), part);
  for (const char* uid : {"1.2.3.1", ""}) {
    const LoadedVolume loaded = load_volume(folder, 1, uid);
    EXPECT_EQ(loaded.volume.geometry().size, (std::array<int, 3>{6, 5, 9}));
    EXPECT_EQ(loaded.volume.geometry().origin_mm.z(), 2);
    EXPECT_EQ(loaded.volume.value(0, 0, 1), 102);
    EXPECT_EQ(loaded.warnings.front(), series.warnings.front());
  }
}

TEST_F(SeriesTest, AmbiguousSeriesAreRefusedHoweverTheyAreOpened) {
  const auto expect_refused = [&](const std::string& why) {
    EXPECT_HAS(find_dicom_series({folder}).series.front().load_error, why);
    for (const char* uid : {"1.2.3.1", ""}) EXPECT_HAS(error_of([&] { load_volume(folder, 1, uid); }), why);
  };
  write_series(folder, {}, 8);
  fs::remove(folder / "chest5");
  expect_refused("1 missing slice (");
  write_series(folder, {}, 8);
  CtSlice{.z_mm = 4, .value = 900}.write(folder / "other");  // other values at the position of chest2
  expect_refused("1 duplicate slice (");
  fs::remove(folder / "other");
  for (int k = 0; k < 9; ++k)  // no orientation has more than half of the images
    CtSlice{.z_mm = 2.0 * k, .sagittal = true}.write(folder / ("sagittal" + std::to_string(k)));
  CtSlice{.z_mm = 80, .columns = 7}.write(folder / "wide");
  expect_refused("different orientations");
}

TEST_F(SeriesTest, BrokenEntriesNeitherStopNorHideAnything) {
  write_series(folder / "a", {}, 4);
  fs::create_symlink(folder / "gone.dcm", folder / "a" / "0missing.dcm");
  fs::create_symlink("loop", folder / "a" / "loop");
  fs::create_symlink(folder / "nowhere", folder / "link");
  fs::create_symlink(folder / "a" / "chest3", folder / "a" / "zlink");  // a copy
  std::ofstream(folder / "a" / "empty.dcm");
  std::ofstream(folder / "a" / "notes.txt");
  for (const char* uid : {"1.2.3.1", ""}) {
    const LoadedVolume loaded = load_volume(folder / "a", 1, uid);
    EXPECT_EQ(loaded.volume.geometry().size[2], 4);
    EXPECT_HAS(loaded.warnings.back(), "unreadable files are skipped (it is a link to a missing file): '0missing.dcm'");
    EXPECT_HAS(loaded.warnings.back(), "'empty.dcm'");
    EXPECT_HAS(loaded.warnings.back(), "'loop'");
    EXPECT_EQ(loaded.warnings.back().find("notes"), std::string::npos);
  }
  EXPECT_EQ(load_volume(folder).volume.geometry().size[2], 4);  // only the subfolder contains images
  const FoundSeries found = find_dicom_series({folder});
  EXPECT_EQ(found.series.size(), 1u);
  EXPECT_EQ(found.unreadable.size(), 4u);
}

TEST_F(SeriesTest, UnusableSeriesHaveAReason) {
  write_series(folder, {}, 2);
  for (const char* name : {"chest0", "chest1"}) fs::resize_file(folder / name, fs::file_size(folder / name) - 20);
  write("broken.dcm", CtSlice{.series = "1.2.3.8"}.bytes().substr(0, 300));
  const FoundSeries found = find_dicom_series({folder});
  ASSERT_EQ(found.series.size(), 1u);
  EXPECT_NE(found.series.front().load_error.find("truncated"), std::string::npos) << found.series.front().load_error;
  EXPECT_TRUE(found.series.front().preview.empty());
  ASSERT_EQ(found.unreadable.size(), 1u);
  EXPECT_NE(found.unreadable.front().find("broken.dcm"), std::string::npos);
  fs::create_directory(folder / "empty");
  EXPECT_NE(error_of([&] { find_dicom_series({folder / "empty"}); }).find("no DICOM image"), std::string::npos);
}

TEST_F(SeriesTest, DicomdirFileNamesIgnoreCase) {
  write_series(folder / "IMAGES" / "ser1", {}, 3);
  write_series(folder / "elsewhere", {.series = "1.2.3.2", .name = "not named"}, 3);
  std::vector<std::string> records;
  for (const char* name : {"IMAGES\\SER1\\CHEST0", "IMAGES\\SER1\\CHEST1", "IMAGES\\SER1\\CHEST2", "IMAGES\\GONE"}) {
    test::DicomData record;
    record.text(0x0004, 0x1430, "CS", "IMAGE").text(0x0004, 0x1500, "CS", name);
    records.push_back(record.bytes);
  }
  test::DicomData directory;
  directory.sequence(0x0004, 0x1220, records);
  write("DICOMDIR", test::dicom_file(directory.bytes, "1.2.840.10008.1.3.10"));
  const FoundSeries found = find_dicom_series({folder / "DICOMDIR"});
  ASSERT_EQ(found.series.size(), 1u);
  EXPECT_EQ(found.series.front().texts.series, "chest");
  EXPECT_EQ(found.series.front().files, 3);
  ASSERT_EQ(found.unreadable.size(), 1u);
  EXPECT_NE(found.unreadable.front().find("GONE"), std::string::npos);
  EXPECT_EQ(load_volume(folder / "DICOMDIR").volume.geometry().size, (std::array<int, 3>{6, 5, 3}));
}

TEST_F(SeriesTest, TheOnlySeriesBelowAFolderIsLoadedAndSeveralAreListed) {
  write_series(folder / "a" / "one", {}, 4);
  const LoadedVolume loaded = load_volume(folder);
  EXPECT_EQ(loaded.volume.geometry().size, (std::array<int, 3>{6, 5, 4}));
  EXPECT_HAS(loaded.warnings.back(), "found in the subfolder");
  write_series(folder / "b", {.series = "1.2.3.2", .name = "scout"}, 2);
  const std::string why = error_of([&] { load_volume(folder); });
  EXPECT_HAS(why, "it contains 2 series ('chest' in ");
  EXPECT_HAS(why, "'scout' in '" + (folder / "b").string() + "'");
  EXPECT_EQ(load_volume(folder / "b").volume.geometry().size[2], 2);
}

TEST_F(SeriesTest, GzipCompressedFilesAreRead) {
  const std::string plain = CtSlice{.value = 40}.bytes();
  write("plain.dcm", plain);
  test::write_gzip(folder / "packed.dcm.gz", plain);
  const LoadedVolume loaded = load_volume(folder / "packed.dcm.gz");
  EXPECT_TRUE(test::same_voxels(loaded.volume, read_volume(folder / "plain.dcm")));
  EXPECT_EQ(loaded.patient, "Doe, Jane");
  test::write_gzip(folder / "cut.dcm.gz", plain.substr(0, plain.size() - 8));
  const std::string why = error_of([&] { load_volume(folder / "cut.dcm.gz"); });
  EXPECT_HAS(why, "cut.dcm.gz");
  EXPECT_EQ(why.find("unpacked.dcm"), std::string::npos) << why;
  std::string damaged = test::bytes_of(folder / "packed.dcm.gz");
  damaged[damaged.size() / 2] ^= 0x55;
  write("damaged.dcm.gz", damaged);
  EXPECT_HAS(error_of([&] { load_volume(folder / "damaged.dcm.gz"); }), "damaged.dcm.gz");
}

TEST_F(SeriesTest, TextsAreConvertedFromTheDeclaredCharacterSet) {
  EXPECT_EQ(utf8_of("M\xfcller", "ISO_IR 100"), "M\u00fcller");
  EXPECT_EQ(utf8_of("\xbb\xee\xda", "ISO_IR 144"), "\u041b\u044e\u043a");
  EXPECT_EQ(utf8_of("M\u00fcller", "ISO_IR 192"), "M\u00fcller");
  EXPECT_EQ(utf8_of("Yamada=\x1b$B;3ED\x1b(B", "\\ISO 2022 IR 87"), "Yamada=\u5c71\u7530");
  EXPECT_EQ(utf8_of("Hong=\x1b$)C\xc8\xab", "\\ISO 2022 IR 149"), "Hong=\ud64d");
  EXPECT_EQ(utf8_of("M\xfcller", ""), "M\u00fcller") << "no character set is declared";
  EXPECT_EQ(utf8_of("M\u00fcller", ""), "M\u00fcller");
  EXPECT_EQ(utf8_of("M\xfcller", "ISO_IR 192"), "M?ller");
  write_series(folder, {.patient = "M\xfcller^J\xf6rg"}, 2);
  EXPECT_EQ(find_dicom_series({folder}).series.front().texts.patient, "M\u00fcller, J\u00f6rg");
}

TEST_F(SeriesTest, ReadersReportProgressAndCanBeCancelled) {
  write_series(folder, {}, 6);
  LoadProgress progress;
  {
    const LoadProgress::Scope scope(progress);
    load_volume(folder);
    EXPECT_EQ(progress.fraction(), 1);
    progress.cancel();
    EXPECT_THROW(load_volume(folder), Cancelled);
    EXPECT_THROW(find_dicom_series({folder}), Cancelled);
    write_volume(folder / "zeros.nii.gz", Volume({.size = {8, 8, 8}}, VoxelType::UInt8));
    EXPECT_THROW(load_volume(folder / "zeros.nii.gz"), Cancelled);
  }
  EXPECT_EQ(load_volume(folder).volume.geometry().size[2], 6);
}

}  // namespace
}  // namespace simplexseg
