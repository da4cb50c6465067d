// SPDX-License-Identifier: Apache-2.0
// Scan of folders, discs and files for DICOM images.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// File, link or folder whose contents are unknown.
struct UnreadableEntry {
  std::filesystem::path path;
  std::string reason;
};

/// DICOM images of a scan.
struct DicomScan {
  std::map<std::string, std::vector<DicomSlice>> series;  ///< slices by series UID, files in alphabetical order
  std::vector<UnreadableEntry> unreadable;                ///< damaged files, broken links, folders without permission
  bool has_folders = false;                               ///< a scanned folder contains subfolders
};

/// Scans files and folders, with or without subfolders. A DICOMDIR among `paths` stands for the files that it lists,
/// or for all files below its folder if it lists none; in a scanned folder it is ignored. Links to files are
/// followed, links to folders are not. Unreadable entries never end the scan; empty files count as unreadable if
/// their name is that of a DICOM file. Reports progress (load_progress.h). Throws Error when one of `paths` is a
/// folder that cannot be read or a damaged DICOMDIR.
DicomScan scan_for_dicom(const std::vector<std::filesystem::path>& paths, bool with_subfolders);

/// Returns one warning that lists the unreadable entries and the reason of the first; empty when there are none.
std::string warning_of(const std::vector<UnreadableEntry>& unreadable);

/// Returns true for the file name of a DICOM directory, DICOMDIR, in any case (PS3.10, 8.6).
bool is_dicomdir(const std::filesystem::path& path);

}  // namespace simplexseg
