// SPDX-License-Identifier: Apache-2.0
// The series that lie in folders, on discs or among files, so that one can be chosen.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_texts.h"
#include "io/volume_source.h"

namespace simplexseg {

struct DicomSeries {
  std::string uid;
  DicomTexts texts;
  std::filesystem::path folder;  ///< that holds all its files, itself or in its subfolders
  bool alone = false;            ///< the folder itself holds its files, and no other series
  int files = 0;
  VolumeGeometry geometry;            ///< of its first volume, where it makes one
  int volumes = 1;                    ///< more than 1: 4D
  std::vector<std::string> warnings;  ///< what was assumed, and what is left out, when it is loaded
  bool damaged = false;               ///< a part of it is left out
  std::string refusal;                ///< why no volume can be made of it; empty when one can
  Volume preview;                     ///< the middle slice, with fewer pixels; empty where it cannot be read
};

struct FoundSeries {
  std::vector<DicomSeries> series;      ///< by patient, date and study, the larger ones of a study first
  std::vector<std::string> unreadable;  ///< one line for each file that is DICOM and damaged, or is named and missing
};

/// Looks through folders with all that is below them, through the files that a DICOMDIR names, and single files.
/// Reports its progress (load_progress.h). Throws Error when there is no image of DICOM at all.
FoundSeries find_dicom_series(const std::vector<std::filesystem::path>& paths);

/// Opens the series with this UID of a folder, searched in its subfolders where the folder itself has it not. Where it
/// makes no volume as it is, the largest part that does is taken, and what is left out and why is a warning: slices
/// that cannot be read, that have another size or orientation or no position, copies of a slice, and what lies beyond a
/// gap. Throws Error when there is no such series, or nothing of it makes a volume.
VolumeSource open_named_series(const std::filesystem::path& folder, const std::string& uid, int volume = 1);

/// Opens the one series that lies below a folder or in the files that a DICOMDIR names, as open_named_series() does.
/// Throws Error when there is none, or several, which it names.
VolumeSource open_only_series(const std::filesystem::path& path, int volume = 1);

/// Whether the name is that of the directory of a disc of DICOM files (PS3.10, 8.6).
bool is_dicomdir(const std::filesystem::path& path);

}  // namespace simplexseg
