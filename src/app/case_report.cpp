// SPDX-License-Identifier: Apache-2.0
#include "app/case_report.h"

#include <ctime>

#include "app/commit.h"
#include "app/slice_picture.h"
#include "app/table.h"
#include "core/number_text.h"
#include "io/dicom/dicom_texts.h"
#include "io/picture/pdf_document.h"
#include "io/platform/atomic_file.h"
#include "io/platform/file_checksum.h"
#include "io/platform/files.h"
#include "io/scene/point_text.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"
#include "session/object_measures.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostPrompts = 400;  ///< rows of the table of prompts
constexpr int kPanelPixels = 500;

using Rows = std::vector<std::vector<std::string>>;

/// Text of a scene for the document, whose texts must be UTF-8.
std::string shown(const std::string& text) { return one_line(as_utf8(text, ""), 200); }

std::string place_text(const Eigen::Vector3d& mm) {
  return fixed_or_dash(mm.x(), 1) + ", " + fixed_or_dash(mm.y(), 1) + ", " + fixed_or_dash(mm.z(), 1);
}

std::string date_text() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char text[64];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S %z", &parts);
  return text;
}

/// Facts about the image, and checksums of its files.
void add_image(PdfDocument& document, const Scene& scene, const Volume& volume, const CaseReportInput& input) {
  std::vector<std::pair<std::string, std::string>> facts;
  if (!input.patient.empty()) facts.emplace_back("Patient", shown(input.patient));
  if (!input.volume_path.empty()) {
    facts.emplace_back("Image", shown(input.volume_path.filename().string()));
    if (!input.series.empty()) facts.emplace_back("Series", shown(input.series));
    const auto& size = volume.geometry().size;
    const Eigen::Vector3d& spacing = volume.geometry().spacing_mm;
    facts.emplace_back("Size", std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
                                   std::to_string(size[2]) + " voxels of " + general_text(spacing.x(), 4) + " x " +
                                   general_text(spacing.y(), 4) + " x " + general_text(spacing.z(), 4) + " mm, " +
                                   to_string(volume.type()));
    const VolumeSource source = open_volume(input.volume_path, scene.volume_number, scene.volume_series);
    std::vector<fs::path> files;
    for (const DicomSlice& slice : source.dicom)
      if (files.empty() || slice.file != files.back()) files.emplace_back(slice.file);
    if (files.size() > 1)
      facts.emplace_back("SHA-256", sha256_of(files) + " (of the list that sha256sum prints for its " +
                                        std::to_string(files.size()) + " files, sorted by name)");
    else
      facts.emplace_back("SHA-256", sha256_of(files.empty() ? input.volume_path : files.front()));
  }
  facts.emplace_back("Program", std::string("SimplexSeg " SIMPLEXSEG_VERSION) +
                                    (*kCommit ? std::string(", commit ") + kCommit : std::string()));
  facts.emplace_back("Date", date_text());
  document.add_facts(facts);
}

void add_objects(PdfDocument& document, const Scene& scene, const Volume& volume, const std::string& unit) {
  const std::string intensity = unit.empty() ? "" : " " + unit;
  Rows rows{{"object", "label", "volume ml", "mean" + intensity, "SD" + intensity, "long mm", "short mm"}};
  for (const MeshItem& item : scene.meshes) {
    if (item.mesh.positions.empty()) continue;
    const ObjectMeasures measures = measure_object(item, scene, volume);
    const auto& intensities = measures.intensities;
    rows.push_back({shown(item.name), std::to_string(item.label), readable(measures.volume_mm3 / 1000, 2),
                    intensities ? readable(intensities->mean, 1) : "-",
                    intensities ? readable(intensities->deviation, 1) : "-",
                    measures.axes ? readable(measures.axes->long_mm(), 1) : "-",
                    measures.axes ? readable(measures.axes->short_mm(), 1) : "-"});
  }
  if (rows.size() == 1) return;
  document.add_heading("Objects");
  document.add_table(rows, 1);
  document.add_paragraph(
      "Volume: inside the surface. Mean and standard deviation (SD): intensities of the voxels of the object. Long and "
      "short axis: longest diameter in an axial slice, and the longest one perpendicular to it there (RECIST 1.1).");
}

void add_measurements(PdfDocument& document, const Scene& scene, const Volume& volume, const std::string& unit) {
  if (scene.measurements.empty()) return;
  Rows rows{{"measurement", "value"}};
  for (const Measurement& measurement : scene.measurements) {
    std::string text;
    for (const std::string& line : lines_of(values_of(measurement, volume), unit))
      text += (text.empty() ? "" : ", ") + line;
    rows.push_back({shown(measurement.name), text});
  }
  document.add_heading("Measurements");
  document.add_table(rows, rows.front().size());
}

void add_pictures(PdfDocument& document, const Scene& scene, const Volume& volume, bool low_is_bright) {
  for (const MeshItem& item : scene.meshes) {
    if (item.mesh.positions.empty()) continue;
    Scene alone;
    alone.meshes.push_back(item);
    alone.meshes.back().visible = true;
    document.add_picture(shown(item.name),
                         draw_slices(volume, alone, low_is_bright, kPanelPixels, {}, SliceFrame::Objects),
                         "Axial, sagittal and coronal slice through the centroid. The patient's right is on the left; "
                         "sagittal: anterior is on the left.");
  }
}

/// Rows of the start of a mesh.
Rows start_rows(const MeshItem& item) {
  if (item.start && item.start->network) {
    const NetworkMask& mask = *item.start->network;
    const std::string licence = mask.licence.empty() ? "not stated" : mask.licence;
    return {{shown(item.name), "mask of a network: " + shown(mask.network), shown(mask.server), ""},
            {"", "licence of its weights: " + shown(licence), "", ""}};
  }
  if (item.start)
    return {{shown(item.name), "start: " + shown(fs::path(item.start->path).filename().string()), "", ""}};
  return {{shown(item.name), "seed", place_text(item.seed.centre_mm), general_text(item.seed.radius_mm, 4)}};
}

std::string kind_text(const UserPoint& point) {
  if (point.is_paint()) return point.kind == MarkKind::Inside ? "paint" : "eraser";
  const std::string shape = point.is_lasso() ? " lasso" : point.is_stroke() ? " stroke" : "";
  return name_of(point.kind) + shape + (point.local ? ", local" : "");
}

void add_prompts(PdfDocument& document, const Scene& scene) {
  Rows rows{{"object", "prompt", "position, LPS, mm", "radius mm"}};
  for (const MeshItem& item : scene.meshes) {
    for (const std::vector<std::string>& row : start_rows(item)) rows.push_back(row);
    for (const UserPoint& point : scene.points)
      if (point.mesh == item.id)
        rows.push_back({shown(item.name), kind_text(point), place_text(point.position_mm),
                        point.radius_mm > 0 ? general_text(point.radius_mm, 4) : "-"});
  }
  if (rows.size() == 1) return;
  const std::size_t count = rows.size() - 1;
  if (count > kMostPrompts) rows.resize(kMostPrompts + 1);
  document.add_heading("Prompts");
  document.add_table(rows, 2);
  if (count > kMostPrompts)
    document.add_paragraph("The first " + std::to_string(kMostPrompts) + " of " + std::to_string(count) +
                           " prompts; the scene file has all.");
}

}  // namespace

bool is_case_report(const fs::path& path) { return extension_of(path) == ".pdf"; }

void write_case_report(const fs::path& path, const Scene& scene, const Volume& volume, const CaseReportInput& input) {
  PdfDocument document("Segmentation report", "SimplexSeg " SIMPLEXSEG_VERSION " - not for diagnostic use");
  document.add_paragraph("Not for diagnostic use.", true);
  add_image(document, scene, volume, input);
  add_objects(document, scene, volume, input.intensity_unit);
  add_measurements(document, scene, volume, input.intensity_unit);
  add_pictures(document, scene, volume, input.low_is_bright);
  add_prompts(document, scene);
  AtomicFile file(path);
  write_bytes(file, document.finish());
  file.commit();
}

}  // namespace simplexseg
