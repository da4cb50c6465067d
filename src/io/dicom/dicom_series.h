// SPDX-License-Identifier: Apache-2.0
// Search for DICOM series in folders, on discs and among files.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
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
  bool damaged = false;               ///< some slices of the series are omitted
  std::string load_error;             ///< reason why the series cannot be loaded; empty when it can
  Volume preview;                     ///< middle slice, at most 128 x 128 pixels; empty when unreadable
};

struct FoundSeries {
  std::vector<DicomSeries> series;      ///< sorted by patient, date, study, then number of files (largest first)
  std::vector<std::string> unreadable;  ///< damaged DICOM files and missing files of a DICOMDIR, one line each
};

/// Searches folders with their subfolders, the files listed in a DICOMDIR, and single files. Reports progress
/// (load_progress.h). Throws Error when there is no DICOM image.
FoundSeries find_dicom_series(const std::vector<std::filesystem::path>& paths);

/// Opens volume number `volume` (from 1) of the series `uid` in the folder or, if the folder itself does not contain
/// the series, in its subfolders. If the slices form no volume, the largest part that forms one is opened. A warning
/// lists the omitted slices: unreadable slices, slices with another size or orientation or without position,
/// duplicates, and slices beyond a gap. Throws Error when the series does not exist or no part of it forms a volume.
VolumeSource open_named_series(const std::filesystem::path& folder, const std::string& uid, int volume = 1);

/// Opens the only series in a folder and its subfolders, or in the files of a DICOMDIR, like open_named_series().
/// Throws Error when there is none, or several; the message lists the first four.
VolumeSource open_only_series(const std::filesystem::path& path, int volume = 1);

/// Returns true for the file name of a DICOM directory, DICOMDIR, in any case (PS3.10, 8.6).
bool is_dicomdir(const std::filesystem::path& path);

}  // namespace simplexseg
