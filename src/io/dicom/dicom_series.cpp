// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_series.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/number_text.h"
#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_repair.h"
#include "io/dicom/dicom_scan.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/platform/worker_process.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxPreviewSide = 128;  // largest width and height of a preview, pixels

using Slices = std::vector<DicomSlice>;

fs::path common_folder(const Slices& slices) {
  fs::path folder = fs::absolute(slices.front().file).lexically_normal().parent_path();
  for (const DicomSlice& s : slices) {
    const fs::path file = fs::absolute(s.file).lexically_normal();
    while (std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first != folder.end())
      folder = folder.parent_path();
  }
  return folder;
}

/// Returns a subsampled slice: every n-th pixel of every n-th row, at most kMaxPreviewSide pixels per side.
Volume preview_of(const DicomSlice& slice) {
  const VoxelType type = voxel_type_of(slice);
  std::vector<std::byte> pixels(static_cast<std::size_t>(slice.pixels.rows) * slice.pixels.columns *
                                bytes_per_voxel(type));
  DicomFrames({slice}).read(slice, type, pixels.data());
  const int stride =
      std::max(1, (std::max(slice.pixels.rows, slice.pixels.columns) + kMaxPreviewSide - 1) / kMaxPreviewSide);
  VolumeGeometry geometry;
  geometry.size = {slice.pixels.columns / stride, slice.pixels.rows / stride, 1};
  if (geometry.size[0] < 1 || geometry.size[1] < 1) return {};
  if (slice.spacing_mm) geometry.spacing_mm.head<2>() = *slice.spacing_mm * stride;
  Volume preview(geometry, type);
  const std::size_t bytes = bytes_per_voxel(type);
  auto* to = static_cast<std::byte*>(preview.data());
  for (int j = 0; j < geometry.size[1]; ++j)
    for (int i = 0; i < geometry.size[0]; ++i, to += bytes)
      std::copy_n(pixels.data() + (static_cast<std::size_t>(j) * stride * slice.pixels.columns + i * stride) * bytes,
                  bytes, to);
  return preview;
}

DicomSeries describe(const std::string& uid, const Slices& slices) {
  DicomSeries series;
  series.uid = uid;
  series.texts = read_dicom_texts(slices.front().file);
  series.folder = common_folder(slices);
  std::set<fs::path> files;
  for (const DicomSlice& s : slices) files.insert(s.file);
  series.files = static_cast<int>(files.size());
  const DicomSlice* middle = &slices[slices.size() / 2];
  try {
    VolumeSource source = open_repaired(slices, "the series", 1, &series.damaged);
    require_one_value(series.folder, source.info);
    series.geometry = source.info.geometry;
    series.volumes = source.info.frames;
    series.warnings = source.info.warnings;
    if (series.volumes > 1)
      std::erase_if(series.warnings, [](const std::string& line) { return line.starts_with("4D: "); });
    if (!source.dicom.empty()) middle = &source.dicom[source.dicom.size() / 2];
    if (middle->unreadable.empty() && middle->pixels.samples == 1) series.preview = preview_of(*middle);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception& exception) {
    const std::string text = exception.what();
    series.load_error = text.starts_with("cannot read ") && text.find(": ") != std::string::npos
                            ? text.substr(text.find(": ") + 2)
                            : text;
  }
  return series;
}

std::string name_of_series(const Slices& slices) {
  const std::string& text = slices.front().description.empty() ? slices.front().series : slices.front().description;
  return "'" + text + "' (" + counted(static_cast<std::int64_t>(slices.size()), "slice") + ", from " +
         quoted(slices.front().file.filename()) + ")";
}

VolumeSource with_warning(VolumeSource source, const std::string& warning) {
  if (!warning.empty()) source.info.warnings.push_back(warning);
  return source;
}

[[noreturn]] void throw_no_series(const std::string& what, const std::string& why, const DicomScan& scan) {
  std::vector<std::string> names;
  for (const UnreadableEntry& entry : scan.unreadable) names.push_back(quoted(entry.path.filename()));
  throw Error(what,
              names.empty()
                  ? why
                  : "no DICOM file in it can be read (" + scan.unreadable.front().reason + "): " + list_of(names),
              "choose a file or the folder of a series");
}

}  // namespace

FoundSeries find_dicom_series(const std::vector<fs::path>& paths) {
  FoundSeries found;
  const DicomScan scan = scan_for_dicom(paths, true);
  for (const UnreadableEntry& entry : scan.unreadable)
    found.unreadable.push_back(quoted(entry.path) + ": " + entry.reason);
  const std::map<std::string, Slices>& all = scan.series;
  const std::string searched = paths.size() == 1 ? quoted(paths.front()) : std::to_string(paths.size()) + " files";
  if (all.empty()) {
    throw Error("cannot read " + searched,
                found.unreadable.empty() ? "it contains no DICOM image"
                                         : "no DICOM file in it can be read (" + found.unreadable.front() + ")",
                "choose the folder of a series");
  }
  for (const auto& [uid, slices] : all) {
    report_progress(1, 1);
    found.series.push_back(describe(uid, slices));
  }
  for (DicomSeries& series : found.series) {
    std::set<fs::path> inside;
    for (const DicomSlice& s : all.at(series.uid)) inside.insert(fs::absolute(s.file).lexically_normal().parent_path());
    series.is_only_series = inside.size() == 1 && std::none_of(all.begin(), all.end(), [&](const auto& other) {
                              return other.first != series.uid &&
                                     std::any_of(other.second.begin(), other.second.end(), [&](const DicomSlice& s) {
                                       return fs::absolute(s.file).lexically_normal().parent_path() == series.folder;
                                     });
                            });
  }
  std::stable_sort(found.series.begin(), found.series.end(), [](const DicomSeries& a, const DicomSeries& b) {
    return std::tie(a.texts.patient, a.texts.date, a.texts.study, b.files) <
           std::tie(b.texts.patient, b.texts.date, b.texts.study, a.files);
  });
  return found;
}

VolumeSource open_dicom_series(const fs::path& folder, int volume) {
  const DicomScan scan = scan_for_dicom({folder}, false);
  if (scan.series.empty() && scan.has_folders) return open_only_series(folder, volume);
  if (scan.series.empty())
    throw_no_series("cannot read the folder " + quoted(folder), "it contains no DICOM images", scan);
  const auto largest = std::max_element(scan.series.begin(), scan.series.end(),
                                        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  std::vector<std::string> others;
  for (auto it = scan.series.begin(); it != scan.series.end(); ++it) {
    if (it != largest) others.push_back(name_of_series(it->second));
  }
  VolumeSource source = open_repaired(largest->second, "the DICOM series in " + quoted(folder), volume);
  if (!others.empty()) {
    source.info.warnings.push_back("the folder contains " + std::to_string(others.size() + 1) +
                                   " series: the largest, " + name_of_series(largest->second) +
                                   ", is loaded; not loaded: " + list_of(others));
  }
  return with_warning(std::move(source), warning_of(scan.unreadable));
}

VolumeSource open_named_series(const fs::path& folder, const std::string& uid, int volume) {
  for (const bool below : {false, true}) {
    const DicomScan scan = scan_for_dicom({folder}, below);
    const auto found = scan.series.find(uid);
    if (found == scan.series.end()) continue;
    return with_warning(open_repaired(found->second, "the DICOM series in " + quoted(folder), volume),
                        warning_of(scan.unreadable));
  }
  throw Error("cannot read " + quoted(folder), "it does not contain the series " + one_line(uid),
              "open the folder that contains the series");
}

VolumeSource open_only_series(const fs::path& path, int volume) {
  const DicomScan scan = scan_for_dicom({path}, true);
  if (scan.series.empty())
    throw_no_series("cannot read " + quoted(path), "neither it nor its subfolders contain DICOM images", scan);
  if (scan.series.size() > 1) {
    constexpr std::size_t kMaxListed = 4;
    std::string list;
    std::size_t named = 0;
    for (const auto& [uid, slices] : scan.series) {
      if (named++ == kMaxListed) break;
      const std::string& name = slices.front().description.empty() ? uid : slices.front().description;
      list.append(list.empty() ? "'" : ", '").append(one_line(name, 60)).append("' in ");
      list += quoted(common_folder(slices));
    }
    throw Error("cannot read " + quoted(path),
                "it contains " + std::to_string(scan.series.size()) + " series (" + list +
                    (scan.series.size() > kMaxListed ? " and others)" : ")"),
                "choose the folder of one series");
  }
  const Slices& slices = scan.series.begin()->second;
  const std::string folder = quoted(common_folder(slices));
  VolumeSource source = open_repaired(slices, "the DICOM series in " + folder, volume);
  source = with_warning(std::move(source), warning_of(scan.unreadable));
  return with_warning(std::move(source), is_dicomdir(path) ? "" : "the series was found in the subfolder " + folder);
}

}  // namespace simplexseg
