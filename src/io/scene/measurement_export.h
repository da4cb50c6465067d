// SPDX-License-Identifier: Apache-2.0
// Export of the measurements of a scene, for the window, the command line and Python.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Files that save_measurements() writes for a name: itself, and for NAME.sr.dcm also NAME.seg.dcm.
std::vector<std::filesystem::path> measurement_files(const std::filesystem::path& path);

/// Throws the errors of save_measurements() that the name and the scene determine before anything is measured: for a
/// structured report, those of require_labels_name(), and two segmentations with the same label.
void require_measurement_name(const std::filesystem::path& path, const Scene& scene);

/// Writes the measurements of a scene in the format of the file name. NAME.sr.dcm: a DICOM structured report of the
/// segmentations (write_structured_report()), and NAME.seg.dcm, the DICOM segmentation to whose segments it refers;
/// other names: a table (measurement_csv()). `unit`: of the intensities, or "". Returns a note for the user as
/// save_labels(). Throws the errors of the writers, and of make_label_map().
std::string save_measurements(const std::filesystem::path& path, const Scene& scene, const Volume& volume,
                              const std::string& unit);

}  // namespace simplexseg
