// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "core/number_text.h"
#include "dicom_series_fixture.h"
#include "io/dicom_write/dicom_seg_write.h"
#include "io/dicom_write/dicom_source.h"
#include "io/labels/label_file.h"
#include "io/labels/labels_io.h"
#include "io/scene/label_preset.h"
#include "io/scene/measurement_export.h"
#include "io/scene/scene_export.h"
#include "io/volume/volume_io.h"
#include "session/label_map.h"
#include "session/object_measures.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::error_of;

class DicomDocuments : public test::DicomSeriesTest {};

TEST_F(DicomDocuments, ALabelMapIsReadBackOnTheSameVoxels) {
  write_series();
  Scene scene = this->scene();
  const VolumeGeometry grid = image().geometry();
  // Labels stay as they are; more than 255 need 16 bits.
  for (const int label : {5, 300}) {
    scene.meshes[0].label = label;
    EXPECT_EQ(save_labels(folder / "a.labelmap.dcm", scene, grid), "");
    const LoadedVolume loaded = load_volume(folder / "a.labelmap.dcm");
    EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings.front();
    expect_same_voxels(make_label_map(scene, grid).labels, loaded.volume);
    ASSERT_EQ(loaded.segments.size(), 2u);
    EXPECT_EQ(loaded.segments[0], (SegmentName{2, "a / ? b", {1, 128, 255}, tissue_code()}));
    EXPECT_EQ(loaded.segments[1], (SegmentName{label, "Left kidney", {230, 160, 60}, code_of_name("Left kidney")}));
  }
}

TEST_F(DicomDocuments, LabelsThatDicomCannotHoldAreRefused) {
  write_series();
  const fs::path path = folder / "a.seg.dcm";
  const auto refusal = [&](const Volume& labels) {
    const std::string message = error_of([&] {
      write_dicom_segmentation(path, labels, {}, read_dicom_source(folder / "ct", path), SegmentEncoding::LabelMap);
    });
    EXPECT_FALSE(fs::exists(path)) << message;
    return message;
  };
  const VolumeGeometry grid = image().geometry();
  EXPECT_HAS(refusal(Volume(grid, VoxelType::Int32)), "no voxel is labelled");
  for (const std::int32_t value : {-3, 65536}) {
    Volume labels(grid, VoxelType::Int32);
    labels.voxels<std::int32_t>()[7] = value;
    EXPECT_HAS(refusal(labels), "a label has the value " + std::to_string(value));
  }
  VolumeGeometry other = grid;
  other.origin_mm[0] += 1;
  EXPECT_HAS(refusal(Volume(other, VoxelType::Int32)), "different grids");
}

TEST_F(DicomDocuments, MeasurementsAreAStructuredReportWithItsSegmentation) {
  write_series();
  Scene scene = this->scene();
  scene.meshes[0].label = 7;  // segment 2 of the segmentation
  const Volume volume = image();
  const fs::path report = folder / "m.sr.dcm", segmentation = folder / "m.seg.dcm";
  EXPECT_EQ(measurement_files(report), (std::vector<fs::path>{report, segmentation}));
  EXPECT_EQ(measurement_files("m.csv"), std::vector<fs::path>{"m.csv"});
  try {
    require_measurement_name(report, scene);
  } catch (const Error& error) {
    EXPECT_HAS(error.what(), "built without DCMTK");
    GTEST_SKIP() << error.what();
  }
  EXPECT_HAS(save_measurements(report, scene, volume, "HU"), "label 7 is segment 2");
  EXPECT_EQ(load_volume(segmentation).segments.at(1).name, "Left kidney");
  EXPECT_HAS(bytes_of(report), "M\xfcller^J") << "patient of the image";
  if (succeeds("command -v dciodvfy")) {
    const std::string message = output_and_errors_of("dciodvfy" + in_shell(report));
    EXPECT_EQ(message.find("Error"), std::string::npos) << message;
    EXPECT_HAS(message, "Comprehensive3DSR");
  }
  if (!succeeds("/usr/bin/python3 -c 'import pydicom'")) GTEST_SKIP() << "python3-pydicom is absent";
  save_labels(folder / "m.labelmap.dcm", scene, volume.geometry());
  std::string reader = "/usr/bin/python3";
  reader.append(in_shell(fs::path(SIMPLEXSEG_SOURCE_DIR) / "tests/io/pydicom_documents.py"));
  std::ostringstream wanted;
  for (const std::size_t m : {1u, 0u}) {
    const ObjectMeasures measures = measure_object(scene.meshes[m], scene, volume);
    const auto text = [](double value) { return general_text(value, 6); };
    wanted << (m == 1 ? "1|a / ? b|Tissue" : "2|Left kidney|Kidney|site Kidney Left") << "|Volume "
           << text(measures.volume_mm3) << " mm3|Attenuation Coefficient Mean " << text(measures.intensities->mean)
           << " [hnsf'U]|Attenuation Coefficient Standard Deviation " << text(measures.intensities->deviation)
           << " [hnsf'U]|Long Axis " << text(measures.axes->long_mm()) << " mm|Short Axis "
           << text(measures.axes->short_mm()) << " mm\n";
  }
  // The groups have the order of the meshes.
  std::string lines =
      output_and_errors_of(reader + in_shell(segmentation) + in_shell(folder / "m.labelmap.dcm") + in_shell(report));
  const std::size_t second = lines.find('\n') + 1;
  EXPECT_EQ(lines.substr(second) + lines.substr(0, second), wanted.str());
}

TEST_F(DicomDocuments, ReportsNeedASegmentForEachObject) {
  write_series();
  Scene scene = this->scene();
  scene.meshes[0].label = scene.meshes[1].label;
  const std::string why = error_of([&] { save_measurements(folder / "m.sr.dcm", scene, image(), ""); });
  EXPECT_TRUE(why.find("two segmentations have the label 2") != std::string::npos ||
              why.find("built without DCMTK") != std::string::npos)
      << why;
  EXPECT_FALSE(fs::exists(folder / "m.seg.dcm"));
  scene.volume_path.clear();
  EXPECT_FALSE(error_of([&] { require_measurement_name(folder / "m.sr.dcm", scene); }).empty());
  EXPECT_NO_THROW(require_measurement_name(folder / "m.csv", scene));
}

TEST_F(DicomDocuments, TheValidatorRejectsOnlyWhatIsNewInLabelMaps) {
  if (!succeeds("command -v dciodvfy")) GTEST_SKIP() << "dciodvfy of dicom3tools is absent";
  write_series();
  save_labels(folder / "a.labelmap.dcm", scene(), image().geometry());
  // The validator of Debian 12 is older than the class. A copy that claims the class of 2006 is checked by its modules.
  const std::string label_map = "1.2.840.10008.5.1.4.1.1.66.7", binary = "1.2.840.10008.5.1.4.1.1.66.4";
  std::string bytes = bytes_of(folder / "a.labelmap.dcm");
  for (std::size_t at = 0; (at = bytes.find(label_map, at)) != std::string::npos;)
    bytes.replace(at, label_map.size(), binary);
  std::istringstream lines(output_and_errors_of("dciodvfy" + in_shell(write("copy.dcm", bytes))));
  int errors = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("Error") == std::string::npos) continue;
    ++errors;
    const auto is_about = [&](const char* part) { return line.find(part) != std::string::npos; };
    EXPECT_TRUE(is_about("LABELMAP") || is_about("SegmentIdentificationSequence") || is_about("Segment Number") ||
                is_about("SegmentNumber not monotonically"))
        << line;
  }
  EXPECT_GT(errors, 0) << "a validator that knows label maps can check the file itself";
}

}  // namespace
}  // namespace simplexseg
