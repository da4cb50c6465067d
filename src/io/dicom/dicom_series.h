// SPDX-License-Identifier: Apache-2.0
// Search for DICOM series in folders, on discs and among files.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom/dicom_folder.h"
#include "io/dicom/dicom_texts.h"
#include "io/source/volume_source.h"

namespace simplexseg {

/// DICOM series found in folders or files.
struct DicomSeries {
  std::string uid;
  DicomTexts texts;
  std::filesystem::path folder;  ///< deepest folder that contains all files of the series, also in subfolders
  bool is_only_series = false;   ///< the folder itself contains all files of the series, and no files of other series
  int files = 0;                 ///< number of files
  VolumeGeometry geometry;       ///< grid of the first volume; default if the series cannot be loaded
  int volumes = 1;               ///< number of volumes; more than 1: 4D
  std::vector<std::string> warnings;  ///< assumptions and omitted slices when the series is loaded
  bool damaged = false;               ///< some images of the series are omitted, open_repaired()
  std::string load_error;             ///< reason why the series cannot be loaded; empty when it can
  Volume preview;                     ///< middle slice, at most 128 x 128 pixels; empty when unreadable
};

struct FoundSeries {
  std::vector<DicomSeries> series;      ///< sorted by patient, date, study, then number of files (largest first)
  std::vector<std::string> unreadable;  ///< DicomScan::unreadable, one line each
};

/// Searches folders with their subfolders, the files listed in a DICOMDIR, and single files. Reports progress
/// (load_progress.h). Throws Error when there is no DICOM image.
FoundSeries find_dicom_series(const std::vector<std::filesystem::path>& paths);

/// Opens volume number `volume` (from 1) of the series with the most slices in a folder, see open_repaired(); the
/// warnings list its other series and unreadable entries. If only subfolders contain DICOM images, calls
/// open_only_series().
VolumeSource open_dicom_series(const std::filesystem::path& folder, int volume = 1);

/// Opens volume number `volume` (from 1) of the series `uid` in the folder or, if the folder itself does not contain
/// the series, in its subfolders, see open_repaired(). The warnings list unreadable entries. Throws Error also when
/// the series does not exist.
VolumeSource open_named_series(const std::filesystem::path& folder, const std::string& uid, int volume = 1);

/// Opens the only series in a folder and its subfolders, or in the files of a DICOMDIR, see open_repaired().
/// Throws Error when there is none, or several; the message lists the first four.
VolumeSource open_only_series(const std::filesystem::path& path, int volume = 1);

}  // namespace simplexseg
