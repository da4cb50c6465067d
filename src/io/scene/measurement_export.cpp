// SPDX-License-Identifier: Apache-2.0
#include "io/scene/measurement_export.h"

#include <set>

#include "io/dicom_write/dicom_sr_write.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/scene/label_preset.h"
#include "io/scene/scene_export.h"
#include "session/measurement_csv.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kReportExtension = ".sr.dcm";

bool is_structured_report(const fs::path& path) {
  return lower_ascii(path.filename().string()).ends_with(kReportExtension);
}

fs::path segmentation_of(const fs::path& report) {
  std::string name = report.string();
  name.resize(name.size() - kReportExtension.size());
  return name + ".seg.dcm";
}

}  // namespace

std::vector<fs::path> measurement_files(const fs::path& path) {
  if (is_structured_report(path)) return {path, segmentation_of(path)};
  return {path};
}

void require_measurement_name(const fs::path& path, const Scene& scene) {
  if (!is_structured_report(path)) return;
  require_structured_reports(path);
  require_labels_name(path, scene);
  std::set<int> labels;
  for (const MeshItem& item : scene.meshes)
    if (!labels.insert(item.label).second)
      throw Error("cannot write " + quoted(path), "two segmentations have the label " + std::to_string(item.label),
                  "give each its own label");
}

std::string save_measurements(const fs::path& path, const Scene& scene, const Volume& volume, const std::string& unit) {
  if (!is_structured_report(path)) {
    AtomicFile file(path);
    write_bytes(file, measurement_csv(scene, volume));
    file.commit();
    return "";
  }
  require_measurement_name(path, scene);
  std::vector<ReportedObject> objects;
  for (const MeshItem& item : scene.meshes)
    if (!item.mesh.positions.empty())
      objects.push_back({item.label, code_of(item), measure_object(item, scene, volume)});
  DicomSource source = source_of(scene, path);
  const WrittenSegmentation segmentation =
      save_segmentation(segmentation_of(path), scene, volume.geometry(), SegmentEncoding::Binary);
  write_structured_report(path, objects, unit, segmentation, std::move(source));
  return segmentation.note;
}

}  // namespace simplexseg
