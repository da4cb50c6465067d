// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <sstream>

#include "core/number_text.h"
#include "dicom_files.h"
#include "dicom_series_fixture.h"
#include "image/label_surface.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "io/dicom/dicom_colour.h"
#include "io/dicom/dicom_identity.h"
#include "io/dicom/dicom_item.h"
#include "io/dicom/rtstruct_grid.h"
#include "io/dicom/rtstruct_raster.h"
#include "io/dicom_write/dicom_source.h"
#include "io/labels/label_file.h"
#include "io/labels/labels_io.h"
#include "io/scene/label_preset.h"
#include "io/scene/scene_export.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "session/label_map.h"
#include "test_files.h"
#include "volume_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::error_of;

class DicomWrite : public test::DicomSeriesTest {};

TEST_F(DicomWrite, ASegmentationIsReadBackOnTheSameVoxels) {
  write_series();
  const Scene scene = this->scene();
  const VolumeGeometry grid = image().geometry();
  EXPECT_EQ(save_labels(folder / "a.dcm", scene, grid), "");
  const LoadedVolume loaded = load_volume(folder / "a.dcm");
  EXPECT_EQ(loaded.format, "DICOM SEG");
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings.front();
  expect_same_voxels(make_label_map(scene, grid).labels, loaded.volume);
  ASSERT_EQ(loaded.segments.size(), 2u);
  EXPECT_EQ(loaded.segments[0], (SegmentName{1, "Left kidney", {230, 160, 60}, code_of_name("Left kidney")}));
  EXPECT_EQ(loaded.segments[1], (SegmentName{2, "a / ? b", {1, 128, 255}, tissue_code()}))
      << "the texts of the images are Latin-1";
}

TEST_F(DicomWrite, ChosenCodesAreStoredAndReadBack) {
  write_series();
  Scene scene = this->scene();
  scene.meshes[0].code = code_of_name("Pancreas");
  scene.meshes[1].code = {{"SCT", "49755003", "Morphologically Abnormal Structure"}, {"99X", "A-1", "M\xc3\xbcll"}, {}};
  save_labels(folder / "a.dcm", scene, image().geometry());
  const LoadedVolume loaded = load_volume(folder / "a.dcm");
  EXPECT_EQ(loaded.segments[0].name, "Left kidney");
  EXPECT_EQ(loaded.segments[0].code, scene.meshes[0].code);
  EXPECT_EQ(loaded.segments[1].code.type, (CodedConcept{"99X", "A-1", "M?ll"}))
      << "the texts of the images are Latin-1";
  LabelFile file(folder / "a.dcm");
  const std::vector<LabelCount> counts = file.count();
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(counts[0].code, scene.meshes[0].code) << "for segmentations made from labels";
  save_labels(folder / "a.rtstruct.dcm", scene, image().geometry());
  const std::vector<StructureRegion> regions = read_structure_regions(folder / "a.rtstruct.dcm");
  EXPECT_EQ(regions.at(0).name.code, scene.meshes[0].code);
  EXPECT_EQ(regions.at(1).name.code.type.value, "A-1");
}

TEST_F(DicomWrite, PatientStudyAndSourceImagesAreStored) {
  write_series();
  save_labels(folder / "a.dcm", scene(), image().geometry());
  save_labels(folder / "a.rtstruct.dcm", scene(), image().geometry());
  for (const char* name : {"a.dcm", "a.rtstruct.dcm"}) {
    const std::string bytes = bytes_of(folder / name);
    for (const char* part : {"M\xfcller^J", "patient 7", "1.2.3.9", "1.2.3.8", "1.2.3.7", "20200102", "ISO_IR 100",
                             "SEMIAUTOMATIC", "Left kidney", kCt})
      EXPECT_NE(bytes.find(part), std::string::npos) << name << ": " << part;
    for (int k = 0; k < kSlices; ++k)
      EXPECT_NE(bytes.find("1.2.3.4." + std::to_string(k + 1)), std::string::npos) << name << ": " << k;
  }
}

TEST_F(DicomWrite, NamesAreUnicodeIfTheImagesAllowIt) {
  write_series("ISO_IR 192");
  save_labels(folder / "a.dcm", scene(), image().geometry());
  EXPECT_EQ(load_volume(folder / "a.dcm").segments[1].name, "a / \xc3\xa9 b");
}

TEST_F(DicomWrite, TextsWithoutCharacterSetBecomeUnicode) {
  // No set, the default set, an unknown set, and UTF-8 stated for texts in Latin-1.
  for (const char* charset : {"", "ISO_IR 6", "latin1", "ISO_IR 192"}) {
    write_series(charset);
    save_labels(folder / "a.dcm", scene(), image().geometry());
    save_labels(folder / "a.rtstruct.dcm", scene(), image().geometry());
    Picture view;
    view.width = view.height = 2, view.rgb.resize(12);
    save_view(folder / "view.dcm", view, scene());
    for (const char* name : {"a.dcm", "a.rtstruct.dcm", "view.dcm"}) {
      const std::string bytes = bytes_of(folder / name);
      EXPECT_NE(bytes.find("M\xc3\xbcller^J"), std::string::npos) << name << ", '" << charset << "'";
      EXPECT_NE(bytes.find("ISO_IR 192"), std::string::npos) << name << ", '" << charset << "'";
      EXPECT_EQ(bytes.find("M\xfcller"), std::string::npos) << name << ", '" << charset << "'";
      if (!succeeds("command -v dciodvfy")) continue;
      const std::string message = output_and_errors_of("dciodvfy" + in_shell(folder / name));
      EXPECT_EQ(message.find("Error"), std::string::npos) << message;
    }
    EXPECT_EQ(load_volume(folder / "a.dcm").segments[1].name, "a / \xc3\xa9 b");
    EXPECT_EQ(read_structure_regions(folder / "a.rtstruct.dcm").at(1).name.name, "a / \xc3\xa9 b");
    fs::remove_all(folder / "ct");
  }
}

TEST_F(DicomWrite, LongNamesRemainDistinct) {
  write_series("ISO_IR 192");
  Scene scene = this->scene();
  // 70 equal characters of two bytes before the difference.
  std::string start;
  for (int n = 0; n < 70; ++n) start += "\xc3\xa9";
  scene.meshes[0].name = start + "a", scene.meshes[1].name = start + "b";
  save_labels(folder / "a.dcm", scene, image().geometry());
  save_labels(folder / "a.rtstruct.dcm", scene, image().geometry());
  const std::string first = start.substr(0, 2 * 64), second = start.substr(0, 2 * 62) + "-2";
  const LoadedVolume labels = load_volume(folder / "a.dcm");
  EXPECT_EQ(labels.segments[0].name, first);
  EXPECT_EQ(labels.segments[1].name, second);
  const std::vector<StructureRegion> regions = read_structure_regions(folder / "a.rtstruct.dcm");
  EXPECT_EQ(regions[0].name.name, first);
  EXPECT_EQ(regions[1].name.name, second);
  DicomSource source;
  EXPECT_EQ(dicom_names({"\xc3\xa9", "\xc3\xa0", "a ", "a", "", "a-2", "a"}, source, 8),
            (std::vector<std::string>{"?", "?-2", "a", "a-2", "unnamed", "a-2-2", "a-3"}))
      << "equal without the characters that the images cannot store";
}

TEST_F(DicomWrite, NonConsecutiveLabelsAreRenumberedWithAMessage) {
  write_series();
  Scene scene = this->scene();
  scene.meshes[0].label = 300, scene.meshes[1].label = 7;
  EXPECT_EQ(save_labels(folder / "a.dcm", scene, image().geometry()),
            "DICOM numbers segments from 1: label 7 is segment 1, label 300 is segment 2");
  const LoadedVolume loaded = load_volume(folder / "a.dcm");
  EXPECT_EQ(loaded.segments[1].name, "Left kidney");
  scene.meshes[0].label = 2, scene.meshes[1].label = 1;
  expect_same_voxels(make_label_map(scene, image().geometry()).labels, loaded.volume);
}

TEST_F(DicomWrite, AMeshOutsideTheImageIsAnEmptySegment) {
  write_series();
  Scene scene = this->scene();
  for (Eigen::Vector3f& p : scene.meshes[0].mesh.positions) p[2] += 500;
  for (const char* name : {"a.dcm", "a.rtstruct.dcm"})
    EXPECT_EQ(save_labels(folder / name, scene, image().geometry()), "");
  const LoadedVolume loaded = load_volume(folder / "a.dcm");
  EXPECT_EQ(loaded.segments.size(), 2u);
  expect_same_voxels(make_label_map(scene, image().geometry()).labels, loaded.volume);
}

TEST_F(DicomWrite, VolumesWithoutDicomImageAreRejected) {
  write_series();
  Scene scene = this->scene();
  const Volume image = this->image();
  write_volume(folder / "image.nii.gz", image);
  const auto refusal = [&](const std::string& volume) {
    scene.volume_path = volume;
    const std::string why = error_of([&] { save_labels(folder / "a.dcm", scene, image.geometry()); });
    EXPECT_EQ(why, error_of([&] { require_labels_name(folder / "a.dcm", scene); })) << "reported before the run";
    EXPECT_HAS(error_of([&] { save_labels(folder / "a.rtstruct.dcm", scene, image.geometry()); }), ".seg.nrrd");
    return why;
  };
  EXPECT_HAS(refusal((folder / "image.nii.gz").string()), "NIfTI-1");
  EXPECT_HAS(refusal((folder / "image.nii.gz").string()), "segment the DICOM series itself");
  EXPECT_HAS(refusal(""), "there is no volume");
  fs::remove_all(folder / "ct");
  write_series("", "");
  EXPECT_HAS(refusal((folder / "ct").string()), "no study or series UID");
  EXPECT_FALSE(fs::exists(folder / "a.dcm"));
  EXPECT_HAS(error_of([&] { write_labels(folder / "a.dcm", make_label_map(scene, image.geometry()).labels); }), ".dcm");
}

TEST_F(DicomWrite, TheValidatorReportsNoErrors) {
  if (!succeeds("command -v dciodvfy")) GTEST_SKIP() << "dciodvfy of dicom3tools is absent";
  write_series();
  for (const char* name : {"a.dcm", "a.rtstruct.dcm"}) {
    save_labels(folder / name, scene(), image().geometry());
    const std::string message = output_and_errors_of("dciodvfy" + in_shell(folder / name));
    EXPECT_EQ(message.find("Error"), std::string::npos) << message;
    EXPECT_EQ(message.find("Warning"), std::string::npos) << message;
    EXPECT_NE(message.find(name == std::string("a.dcm") ? "Segmentation" : "RTStructureSet"), std::string::npos)
        << message;
  }
}

TEST_F(DicomWrite, AViewIsASecondaryCaptureInTheSameStudy) {
  write_series();
  Picture view;
  view.width = 5, view.height = 3;
  for (int n = 0; n < 3 * view.width * view.height; ++n) view.rgb.push_back(static_cast<std::uint8_t>(5 * n));
  const fs::path file = folder / "view.dcm";
  save_view(file, view, scene());
  const std::string bytes = bytes_of(file);
  const std::string pixels(view.rgb.begin(), view.rgb.end());
  EXPECT_TRUE(bytes.ends_with(pixels + std::string(1, '\0')));  // an even number of bytes
  const DicomIdentity capture = read_dicom_identity(file), image = read_dicom_identity(file_of(0));
  EXPECT_EQ(capture.study, image.study);
  EXPECT_NE(capture.series, image.series);
  EXPECT_NE(bytes.find("patient 7"), std::string::npos);
  EXPECT_NE(error_of([&] { save_view(folder / "b.dcm", Picture(), scene()); }).find("0 x 0 pixels"), std::string::npos);
  Scene elsewhere = scene();
  elsewhere.volume_path.clear();
  EXPECT_FALSE(error_of([&] { require_view_name(file, elsewhere); }).empty());
  require_view_name("a.png", elsewhere);
  if (!succeeds("command -v dciodvfy")) GTEST_SKIP() << "dciodvfy of dicom3tools is absent";
  const std::string message = output_and_errors_of("dciodvfy" + in_shell(file));
  EXPECT_EQ(message.find("Error"), std::string::npos) << message;
  EXPECT_NE(message.find("SCImage"), std::string::npos) << message;
}

TEST_F(DicomWrite, IdentitiesRequireCompleteFiles) {
  write_series();
  const std::string bytes = bytes_of(file_of(0));
  const DicomIdentity identity = read_dicom_identity(file_of(0));
  EXPECT_EQ(identity.sop_class, kCt);
  EXPECT_EQ(identity.series, "1.2.3.8");
  EXPECT_EQ(identity.transfer_syntax, test::kExplicitLittle);
  EXPECT_NE(error_of([&] { read_dicom_identity(write("cut", bytes.substr(0, bytes.size() - 100))); }).find("truncated"),
            std::string::npos);
  EXPECT_NE(error_of([&] { read_dicom_identity(write("text", "no DICOM")); }).find("not a DICOM file"),
            std::string::npos);
  EXPECT_FALSE(error_of([&] { read_dicom_identity(folder / "absent"); }).empty());
}

TEST_F(DicomWrite, ContoursAreReadBackOnTheSameVoxels) {
  write_series();
  Scene scene = this->scene();
  const VolumeGeometry grid = image().geometry();
  save_labels(folder / "a.rtstruct.dcm", scene, grid);
  EXPECT_TRUE(is_structure_set(folder / "a.rtstruct.dcm"));
  EXPECT_FALSE(is_structure_set(folder / "missing.dcm"));
  const StructureLabels read = read_structure_set(folder / "a.rtstruct.dcm", grid);
  ASSERT_EQ(read.segments.size(), scene.meshes.size());
  std::vector<Mask> masks;
  for (const MeshItem& item : scene.meshes) masks.push_back(rasterise(item.mesh, grid));
  std::size_t shared = 0, inside = 0;
  for (std::size_t v = 0; v < grid.voxel_count(); ++v) {
    int wanted = 0;
    for (std::size_t m = 0; m < masks.size(); ++m) {
      if (!masks[m].voxels[v]) continue;
      shared += wanted != 0;
      if (wanted == 0) wanted = static_cast<int>(m) + 1;
    }
    inside += wanted != 0;
    ASSERT_EQ(read.labels.voxels<std::uint16_t>()[v], wanted) << v;
  }
  EXPECT_GT(inside, 100u);
  EXPECT_EQ(read.warnings.size(), shared > 0 ? 1u : 0u);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    EXPECT_EQ(read.segments[m].value, static_cast<int>(m) + 1);
    EXPECT_EQ(read.segments[m].colour, scene.meshes[m].colour);
  }
  EXPECT_EQ(read.segments[0].name, scene.meshes[0].name);
  // Loading as labels gives the same voxels. The contours cross the slices of a tilted grid.
  std::vector<std::string> warnings;
  EXPECT_TRUE(
      test::same_voxels(load_labels_onto(folder / "a.rtstruct.dcm", grid, "the volume", warnings), read.labels));
  VolumeGeometry tilted = grid;
  tilted.direction = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()).toRotationMatrix() * grid.direction;
  EXPECT_HAS(error_of([&] { read_structure_set(folder / "a.rtstruct.dcm", tilted); }), "cross slices");
  VolumeGeometry beside = grid;
  beside.origin_mm += 1000 * grid.direction.col(2);
  EXPECT_HAS(error_of([&] { read_structure_set(folder / "a.rtstruct.dcm", beside); }), "no closed contour");
  const std::string whole = test::bytes_of(folder / "a.rtstruct.dcm");
  EXPECT_HAS(error_of([&] { read_structure_set(write("cut.dcm", whole.substr(0, whole.size() / 2)), grid); }),
             "cut.dcm");
}

TEST_F(DicomWrite, RegionsBecomeMeshesWithoutTheirImage) {
  write_series();
  const Scene scene = this->scene();
  const VolumeGeometry grid = image().geometry();
  const fs::path path = folder / "a.rtstruct.dcm";
  save_labels(path, scene, grid);
  for (const MeshItem& item : scene.meshes) {
    const LabelChoice chosen{.label = item.label, .name = item.id == 1 ? "left KIDNEY" : ""};
    const LoadedLabels loaded = load_labels(path, chosen);
    EXPECT_TRUE(loaded.warnings.empty());
    EXPECT_EQ(label_of(chosen, loaded.segments, path), item.label);
    // The slice distance equals that of the image, the pixels are smaller; the shape is the original mesh.
    EXPECT_NEAR(loaded.volume.geometry().spacing_mm[2], grid.spacing_mm[2], 1e-3);
    EXPECT_LE(loaded.volume.geometry().spacing_mm[0], 1.25);
    const SimplexMesh mesh = mesh_of_mask(mask_of(loaded.volume, item.label));
    EXPECT_EQ(topology_of(mesh).surfaces, 1);
    EXPECT_EQ(topology_of(mesh).genus, topology_of(item.mesh).genus);
    EXPECT_GT(dice(rasterise(item.mesh, grid), rasterise(mesh, grid)), 0.95) << item.name;
  }
  EXPECT_EQ(LabelFile(path).count().size(), 2u);
  EXPECT_EQ(LabelFile(path).count()[0].name, "Left kidney");
  EXPECT_HAS(error_of([&] { load_labels(path, {.name = "spleen"}); }), "its labels are Left kidney");
  EXPECT_HAS(error_of([&] { load_labels(path, {.label = 9}); }), "has no label 9: its labels are 1 (Left kidney)");
  // A mesh of a scene can start from a region and keeps its number.
  write("scene.json", R"({"simplexseg_scene": 1, "volume": "ct", "meshes": [
      {"name": "k", "start": {"labels": "a.rtstruct.dcm", "label": "Left kidney"}}]})");
  const MeshItem item = read_scene(folder / "scene.json").scene.meshes.at(0);
  ASSERT_TRUE(item.start && item.start->mesh);
  EXPECT_EQ(item.start->value, 1);
  EXPECT_GT(dice(rasterise(scene.meshes[0].mesh, grid), rasterise(*item.start->mesh, grid)), 0.95);
}

TEST(RegionsGrid, InvalidPlanesAreRejected) {
  const auto square = [](double z, double lift = 0) {
    return std::vector<double>{0, 0, z, 10, 0, z + lift, 10, 10, z + lift, 0, 10, z};
  };
  const auto region = [](const std::vector<std::vector<double>>& contours) {
    StructureRegion made;
    made.contours = contours;
    return made;
  };
  const auto refusal = [&](const std::vector<std::vector<double>>& contours) {
    const std::vector<StructureRegion> regions(1, region(contours));
    return error_of([&] { grid_of_regions(regions, regions, "rt.dcm"); });
  };
  std::vector<StructureRegion> even(1, region({square(3), square(9), square(12)}));
  even.push_back(region({square(5)}));
  const VolumeGeometry grid = grid_of_regions({even.data(), 1}, even, "rt.dcm");
  EXPECT_NEAR(grid.spacing_mm[2], 3, 1e-9);
  EXPECT_EQ(grid.size[2], 4 + 2);
  EXPECT_NEAR(grid_of_regions({even.data() + 1, 1}, even, "rt.dcm").spacing_mm[2], 2, 1e-9) << "from all planes";
  EXPECT_HAS(refusal({square(3)}), "single plane");
  EXPECT_HAS(refusal({square(3), square(5), square(8.1)}), "unevenly spaced");
  EXPECT_HAS(refusal({square(3), square(6, 4)}), "not parallel");
  EXPECT_HAS(refusal({square(3), square(1e6), square(1e6 + 1)}), "too close");
  EXPECT_HAS(refusal({}), "no closed contour");
}

TEST_F(DicomWrite, SlicesWithoutContourAreReported) {
  write_series();
  Scene scene = this->scene();
  scene.meshes.pop_back();
  save_labels(folder / "a.rtstruct.dcm", scene, image().geometry());
  std::vector<StructureRegion> regions = read_structure_regions(folder / "a.rtstruct.dcm");
  ASSERT_GT(regions.at(0).contours.size(), 4u);
  regions[0].contours.erase(regions[0].contours.begin() + 2);
  const LoadedLabels loaded = labels_of_regions(regions, {}, "rt.dcm");
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_HAS(loaded.warnings[0], "1 slice between the first and the last has no contour");
}

TEST_F(DicomWrite, PydicomReadsTheSameVoxels) {
  // The system's Python has Debian's pydicom.
  if (!succeeds("/usr/bin/python3 -c 'import pydicom'")) GTEST_SKIP() << "python3-pydicom is absent";
  write_series();
  const Scene scene = this->scene();
  const VolumeGeometry grid = image().geometry();
  const Volume labels = make_label_map(scene, grid).labels;
  std::ostringstream segments, regions;
  for (const MeshItem& item : scene.meshes) {
    const std::string name = item.id == 1 ? "Left kidney" : "a / ? b";
    const char* code =
        item.id == 1 ? "|SCT 123037004, SCT 64033007 Kidney, SCT 7771000 Left" : "|SCT 85756007, SCT 85756007 Tissue";
    segments << name << code;
    regions << name << '|' << (item.id == 1 ? "230/160/60" : "1/128/255") << code;
    const Mask mask = rasterise(item.mesh, grid);
    for (int k = 0; k < kSlices; ++k) {
      int of_labels = 0, of_mesh = 0;
      for (int j = 0; j < kRows; ++j)
        for (int i = 0; i < kColumns; ++i) {
          of_labels += labels.value(i, j, k) == item.label;
          of_mesh += mask.voxels[labels.offset(i, j, k)];
        }
      segments << '|' << of_labels, regions << '|' << of_mesh;
    }
    segments << '\n', regions << '\n';
  }
  std::string reader = "/usr/bin/python3";
  reader.append(in_shell(fs::path(SIMPLEXSEG_SOURCE_DIR) / "tests/io/pydicom_reader.py"));
  save_labels(folder / "a.dcm", scene, grid);
  EXPECT_EQ(output_and_errors_of(reader + in_shell(folder / "a.dcm") + images()), segments.str());
  save_labels(folder / "a.rtstruct.dcm", scene, grid);
  EXPECT_EQ(output_and_errors_of(reader + in_shell(folder / "a.rtstruct.dcm") + images()), regions.str());
}

TEST(DicomColour, ColoursRoundTrip) {
  for (int red = 0; red < 256; red += 15)
    for (int green = 0; green < 256; green += 15)
      for (int blue = 0; blue < 256; blue += 15) {
        const Colour colour{std::uint8_t(red), std::uint8_t(green), std::uint8_t(blue)};
        ASSERT_EQ(colour_of_lab(lab_of_colour(colour)), colour) << red << ' ' << green << ' ' << blue;
      }
  // White is L* = 100, a* = b* = 0 by definition.
  const DicomLab white = lab_of_colour({255, 255, 255});
  EXPECT_EQ(white[0], 65535);
  EXPECT_NEAR(white[1], 128.0 / 255 * 65535, 20);
  EXPECT_NEAR(white[2], 128.0 / 255 * 65535, 20);
}

TEST(DicomItem, DecimalStringsFitAndKeepTheirDigits) {
  for (const double value :
       {0.0, -1.0, 0.1, 1.0 / 3, -1.0 / 3, -123456.789012345, 1e-7, -1.23456789012345e-300, 3e300}) {
    const std::string text = decimal_string(value);
    EXPECT_LE(text.size(), 16u) << text;
    EXPECT_NEAR(parse_number(text).value_or(std::nan("")), value, 1e-8 * std::abs(value)) << text;
  }
}

}  // namespace
}  // namespace simplexseg
