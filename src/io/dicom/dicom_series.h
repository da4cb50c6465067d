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

struct DicomSeries {
  std::string uid;
  DicomTexts texts;
  std::filesystem::path folder;  ///< deepest folder that contains all its files, also in subfolders
  bool is_only_series = false;   ///< the folder itself contains all its files and no other series
  int files = 0;
  VolumeGeometry geometry;            ///< grid of its first volume, if it has one
  int volumes = 1;                    ///< more than 1: 4D
  std::vector<std::string> warnings;  ///< assumptions and omitted slices when it is loaded
  bool damaged = false;               ///< some of its slices are omitted
  std::string load_error;             ///< reason why it cannot be loaded; empty when it can
  Volume preview;                     ///< middle slice at reduced size; empty when unreadable
};

struct FoundSeries {
  std::vector<DicomSeries> series;      ///< sorted by patient, date, study, then size (largest first)
  std::vector<std::string> unreadable;  ///< damaged DICOM files and missing files of a DICOMDIR, one line each
};

/// Searches folders with their subfolders, the files of a DICOMDIR, and single files. Reports progress
/// (load_progress.h). Throws Error when there is no DICOM image.
FoundSeries find_dicom_series(const std::vector<std::filesystem::path>& paths);

/// Opens the series `uid` in the folder or, if it is not there, in its subfolders. If its slices form no volume, the
/// largest part that does is opened. A warning lists the omitted slices: unreadable ones, ones with another size or
/// orientation or without position, duplicates, and slices beyond a gap. Throws Error when the series does not exist or
/// no part of it forms a volume.
VolumeSource open_named_series(const std::filesystem::path& folder, const std::string& uid, int volume = 1);

/// Opens the only series below a folder or in the files of a DICOMDIR, like open_named_series(). Throws Error when
/// there is none, or several; the message lists them.
VolumeSource open_only_series(const std::filesystem::path& path, int volume = 1);

/// Returns true for the file name of a DICOM directory, DICOMDIR (PS3.10, 8.6).
bool is_dicomdir(const std::filesystem::path& path);

}  // namespace simplexseg
