// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_folder.h"

#include <gdcmReader.h>

#include <algorithm>
#include <system_error>

#include "core/number_text.h"
#include "core/system_error.h"
#include "io/dicom/dicom_requests.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_validation.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

bool is_named_like_dicom(const fs::path& path) {
  const std::string extension = extension_of(path);
  return extension.empty() || extension == ".dcm" || extension == ".dicom" || extension == ".ima" ||
         extension == ".dic" || extension.find_first_not_of(".0123456789") == std::string::npos;
}

/// List of the files in folders.
class FileList {
 public:
  FileList(DicomScan& scan, bool with_subfolders) : scan_(scan), with_subfolders_(with_subfolders) {}

  /// Adds the files of a folder. Throws Error when it cannot be read.
  void add_folder(const fs::path& folder) {
    if (const std::error_code error = add_entries(folder))
      throw Error("cannot read the folder " + quoted(folder), system_error_text(error), "check its permissions");
  }
  void add_file(const fs::path& file) { files_.push_back(file); }

  /// Returns all files in alphabetical order.
  std::vector<fs::path> finish() && {
    std::sort(files_.begin(), files_.end());
    files_.erase(std::unique(files_.begin(), files_.end()), files_.end());
    return std::move(files_);
  }

 private:
  std::error_code add_entries(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> entries;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      entries.push_back(it->path());
    std::sort(entries.begin(), entries.end());
    for (const fs::path& entry : entries) add_entry(entry);
    return error;
  }

  void add_entry(const fs::path& path) {
    std::error_code error;
    const bool is_link = fs::is_symlink(path, error);
    const fs::file_status status = fs::status(path, error);
    if (!fs::status_known(status)) {
      scan_.unreadable.push_back({path, system_error_text(error)});
    } else if (is_link && !fs::exists(status)) {
      scan_.unreadable.push_back({path, "it is a link to a missing file"});
    } else if (fs::is_directory(status)) {
      scan_.has_folders = true;
      if (!with_subfolders_ || is_link) return;
      if (const std::error_code reason = add_entries(path))
        scan_.unreadable.push_back({path, system_error_text(reason)});
    } else if (fs::is_regular_file(status)) {
      if (fs::file_size(path, error) > 0)
        files_.push_back(path);
      else if (is_named_like_dicom(path))
        scan_.unreadable.push_back({path, "the file is empty"});
    }
  }

  DicomScan& scan_;
  bool with_subfolders_;
  std::vector<fs::path> files_;
};

/// Finds the file with this name, ignoring upper and lower case, because names on a disc can differ in case from those
/// in its DICOMDIR; empty when there is none.
fs::path find_named(const fs::path& folder, const std::string& name) {
  std::error_code error;
  if (fs::exists(folder / name, error)) return folder / name;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (lower_ascii(it->path().filename().string()) == lower_ascii(name)) return it->path();
  return {};
}

/// Adds the files listed in the records of a DICOMDIR (PS3.3, F.3).
void add_dicomdir(const fs::path& path, FileList& files, std::vector<UnreadableEntry>& unreadable) {
  std::vector<std::string> names;
  std::string damage = damage_of_header(path);
  try {
    if (damage.empty()) names = request_result(kDicomdirNames, path, limits_for_file(path));
  } catch (const WorkerFailure& failure) {
    damage = failure.what();
  }
  if (!damage.empty()) throw Error("cannot read " + quoted(path), damage, "open the folder instead");
  const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
  if (names.empty()) return files.add_folder(folder);
  for (const std::string& name : names) {
    fs::path place = folder;
    for (std::size_t at = 0; at <= name.size() && !place.empty();) {
      const std::size_t end = std::min(name.find('\\', at), name.size());
      place = find_named(place, name.substr(at, end - at));
      at = end + 1;
    }
    if (place.empty())
      unreadable.push_back({one_line(name), "the DICOMDIR lists this file, which does not exist"});
    else
      files.add_file(place);
  }
}

}  // namespace

std::vector<std::string> in_reader::names_in_dicomdir(const fs::path& path) {
  std::vector<std::string> names;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) return names;
  each_item(reader.GetFile().GetDataSet(), {0x0004, 0x1220}, [&](const gdcm::DataSet& record) {
    const std::string name = raw_text_of(record, {0x0004, 0x1500});
    if (!name.empty()) names.push_back(name);
  });
  return names;
}

DicomScan scan_for_dicom(const std::vector<fs::path>& paths, bool with_subfolders) {
  DicomScan scan;
  FileList list(scan, with_subfolders);
  for (const fs::path& path : paths) {
    std::error_code error;
    if (fs::is_directory(path, error)) {
      list.add_folder(path);
    } else if (is_dicomdir(path)) {
      require_file(path);
      FileList below(scan, true);
      add_dicomdir(path, below, scan.unreadable);
      for (const fs::path& file : std::move(below).finish()) list.add_file(file);
    } else {
      list.add_file(path);
    }
  }
  const std::vector<fs::path> files = std::move(list).finish();
  std::vector<DicomFileScan> scans = scan_dicom_files(files, [&files](std::size_t done) {
    report_progress(static_cast<double>(done), static_cast<double>(files.size()));
  });
  for (std::size_t n = 0; n < files.size(); ++n) {
    if (!scans[n].failure.empty()) scan.unreadable.push_back({files[n], scans[n].failure});
    for (DicomSlice& slice : scans[n].slices) scan.series[slice.series].push_back(std::move(slice));
  }
  return scan;
}

std::string warning_of(const std::vector<UnreadableEntry>& unreadable) {
  if (unreadable.empty()) return {};
  std::vector<std::string> names;
  names.reserve(unreadable.size());
  for (const UnreadableEntry& entry : unreadable) names.push_back(quoted(entry.path.filename()));
  return "unreadable files are skipped (" + unreadable.front().reason + "): " + list_of(names);
}

bool is_dicomdir(const fs::path& path) { return lower_ascii(path.filename().string()) == "dicomdir"; }

}  // namespace simplexseg
