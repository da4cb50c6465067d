// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_series.h"

#include <gdcmReader.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "io/dicom/dicom.h"
#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_segments.h"
#include "io/dicom/dicom_validation.h"
#include "io/dicom/dicom_values.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/platform/load_progress.h"
#include "io/platform/quiet_libraries.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxPreviewSide = 128;  // largest width and height of a preview, pixels

using Slices = std::vector<DicomSlice>;

// ---- files ----

/// Returns true for files that are worth parsing as DICOM. Files of other programs can be large and are not parsed.
bool may_be_dicom(const fs::path& path) {
  const std::string extension = extension_of(path);
  return extension.empty() || extension == ".dcm" || extension == ".dicom" || extension == ".ima" ||
         extension == ".dic" || extension.find_first_not_of(".0123456789") == std::string::npos ||
         has_dicom_preamble(path);
}

std::vector<fs::path> files_in(const fs::path& folder, bool below) {
  std::vector<fs::path> files;
  std::error_code error, ignored;
  const auto add_if_dicom = [&](const fs::directory_entry& entry) {
    if (entry.is_regular_file(ignored) && entry.file_size(ignored) > 0 && may_be_dicom(entry.path()))
      files.push_back(entry.path());
  };
  constexpr auto kOptions = fs::directory_options::skip_permission_denied;
  if (below) {
    for (fs::recursive_directory_iterator it(folder, kOptions, error), end; !error && it != end; it.increment(error))
      add_if_dicom(*it);
  } else {
    for (fs::directory_iterator it(folder, kOptions, error), end; !error && it != end; it.increment(error))
      add_if_dicom(*it);
  }
  if (error) throw Error("cannot read the folder " + quoted(folder), error.message(), "check its permissions");
  std::sort(files.begin(), files.end());
  return files;
}

/// Returns the file of this name in any case, because names on a disc can differ in case from those in its DICOMDIR;
/// empty when there is none.
fs::path find_named(const fs::path& folder, const std::string& name) {
  std::error_code error;
  if (fs::exists(folder / name, error)) return folder / name;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (lower_case(it->path().filename().string()) == lower_case(name)) return it->path();
  return {};
}

/// Returns the files listed in the records of a DICOMDIR (PS3.3, F.3), or all files below its folder if it lists none.
/// Adds a line to `missing` for each listed file that does not exist.
std::vector<fs::path> files_of_dicomdir(const fs::path& path, std::vector<std::string>& missing) {
  std::vector<std::string> names;
  if (const std::string damage = damage_of_header(path); !damage.empty())
    throw Error("cannot read " + quoted(path), damage, "open the folder instead");
  without_aborting([&] {
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (!reader.Read()) return;
    each_item(reader.GetFile().GetDataSet(), {0x0004, 0x1220}, [&](const gdcm::DataSet& record) {
      const std::string name = raw_text_of(record, {0x0004, 0x1500});
      if (!name.empty()) names.push_back(name);
    });
  });
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    fs::path place = path.parent_path().empty() ? fs::path(".") : path.parent_path();
    for (std::size_t at = 0; at <= name.size() && !place.empty();) {
      const std::size_t end = std::min(name.find('\\', at), name.size());
      place = find_named(place, name.substr(at, end - at));
      at = end + 1;
    }
    if (place.empty())
      missing.push_back("the DICOMDIR lists '" + one_line(name) + "', which does not exist");
    else
      files.push_back(place);
  }
  if (names.empty()) return files_in(path.parent_path().empty() ? fs::path(".") : path.parent_path(), true);
  return files;
}

/// Returns the slices of all files, grouped by series UID. Adds a line to `unreadable` for each damaged file.
std::map<std::string, Slices> scan_files(const std::vector<fs::path>& files, std::vector<std::string>& unreadable) {
  std::map<std::string, Slices> series;
  std::size_t done = 0;
  for (const fs::path& file : files) {
    report_progress(static_cast<double>(done++), static_cast<double>(files.size()));
    try {
      for (DicomSlice& slice : scan_dicom(file)) series[slice.series].push_back(std::move(slice));
    } catch (const std::exception& exception) {
      unreadable.push_back(quoted(file) + ": " + message_of(exception));
    }
  }
  return series;
}

// ---- largest part of a damaged series ----

/// Omitted slices, grouped by reason.
struct Omitted {
  std::vector<std::string> reasons;
  std::size_t count = 0;

  void add(const Slices& slices, const std::string& why) {
    if (slices.empty()) return;
    std::vector<std::string> names;
    for (const DicomSlice& s : slices) names.push_back(name_of(s));
    count += slices.size();
    reasons.push_back(std::to_string(slices.size()) + " " + why + " (" + list_of(names, 4) + ")");
  }
};

/// Returns the slices for which `is_usable` is true, or all slices if it is true for none. Adds the others to `omitted`
/// with the reason `why`.
template <class Predicate>
Slices filter_slices(Slices slices, const Predicate& is_usable, const std::string& why, Omitted& omitted) {
  const auto rest = std::stable_partition(slices.begin(), slices.end(), is_usable);
  if (rest == slices.begin()) return slices;
  omitted.add(Slices(rest, slices.end()), why);
  slices.erase(rest, slices.end());
  return slices;
}

/// Returns the largest group of slices for which `same` is true. Adds the others to `omitted` with the reason `why`.
template <class Same>
Slices largest_group(Slices slices, const Same& same, const std::string& why, Omitted& omitted) {
  std::vector<std::pair<const DicomSlice*, std::size_t>> groups;
  for (const DicomSlice& s : slices) {
    const auto found =
        std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return same(*group.first, s); });
    if (found == groups.end())
      groups.emplace_back(&s, 1);
    else
      ++found->second;
  }
  const auto largest =
      std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (largest == groups.end()) return slices;
  const DicomSlice first = *largest->first;
  return filter_slices(
      std::move(slices), [&](const DicomSlice& s) { return same(first, s); }, why, omitted);
}

bool same_plane(const DicomSlice& a, const DicomSlice& b) {
  if (a.axes.has_value() != b.axes.has_value()) return false;
  return !a.axes || (*a.axes - *b.axes).cwiseAbs().maxCoeff() <= 1e-3;
}

bool same_size(const DicomSlice& a, const DicomSlice& b) {
  if (a.pixels.rows != b.pixels.rows || a.pixels.columns != b.pixels.columns || a.pixels.samples != b.pixels.samples)
    return false;
  return a.spacing_mm.has_value() == b.spacing_mm.has_value() &&
         (!a.spacing_mm || a.spacing_mm->isApprox(*b.spacing_mm, 1e-3));
}

/// Returns the longest run of evenly spaced slices, one for each position. Adds the others to `omitted`.
Slices longest_run(Slices slices, Omitted& omitted) {
  if (slices.empty() || !slices.front().axes || !slices.front().position) return slices;
  constexpr double kSamePositionMm = 0.01;
  const Eigen::Vector3d normal = slices.front().axes->col(0).cross(slices.front().axes->col(1)).normalized();
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return std::tuple(place(a), a.file, a.frame) < std::tuple(place(b), b.file, b.frame);
  });
  Slices copies, single;
  for (DicomSlice& s : slices) {
    const bool is_copy = !single.empty() && place(s) - place(single.back()) <= kSamePositionMm;
    (is_copy ? copies : single).push_back(std::move(s));
  }
  omitted.add(copies, "at the position of another slice");
  if (single.size() < 3) return single;
  std::vector<double> gaps;
  for (std::size_t n = 1; n < single.size(); ++n) gaps.push_back(place(single[n]) - place(single[n - 1]));
  std::vector<double> sorted = gaps;
  std::nth_element(sorted.begin(), sorted.begin() + (sorted.size() - 1) / 2, sorted.end());
  const double spacing = sorted[(sorted.size() - 1) / 2];
  std::size_t first = 0, best_first = 0, best_count = 0;
  for (std::size_t n = 1; n <= single.size(); ++n) {
    if (n < single.size() && std::abs(gaps[n - 1] / spacing - 1) <= 0.1) continue;
    if (n - first > best_count) best_first = first, best_count = n - first;
    first = n;
  }
  const auto begin = single.begin() + static_cast<std::ptrdiff_t>(best_first);
  const auto end = begin + static_cast<std::ptrdiff_t>(best_count);
  Slices beyond(single.begin(), begin);
  beyond.insert(beyond.end(), end, single.end());
  omitted.add(beyond, "beyond a gap between slices");
  return Slices(begin, end);
}

Slices usable_part(Slices slices, Omitted& omitted) {
  slices = filter_slices(
      std::move(slices), [](const DicomSlice& s) { return s.unreadable.empty(); }, "unreadable", omitted);
  slices = filter_slices(
      std::move(slices), [](const DicomSlice& s) { return s.position && s.axes; }, "without a position", omitted);
  slices = largest_group(std::move(slices), same_plane, "with another orientation", omitted);
  slices = largest_group(std::move(slices), same_size, "with another size or spacing", omitted);
  return longest_run(std::move(slices), omitted);
}

/// Opens the series or its largest usable part. Sets `damaged` to true when slices are omitted, otherwise to false.
VolumeSource open_part(Slices slices, const std::string& series_name, int volume, bool& damaged) {
  damaged = false;
  try {
    return open_dicom_slices(slices, "DICOM series", series_name, volume);
  } catch (const Error&) {
    if (is_segmentation(slices.front())) throw;
    const std::size_t all = slices.size();
    Omitted omitted;
    Slices part = usable_part(slices, omitted);
    if (omitted.count == 0 || part.empty()) throw;
    const std::size_t loaded = part.size();
    VolumeSource source = open_dicom_slices(std::move(part), "DICOM series", series_name, volume);
    std::string line =
        "only " + std::to_string(loaded) + " of " + std::to_string(all) + " slices are loaded; omitted: ";
    for (std::size_t n = 0; n < omitted.reasons.size(); ++n) line += (n > 0 ? ", " : "") + omitted.reasons[n];
    source.info.warnings.insert(source.info.warnings.begin(), line);
    damaged = true;
    return source;
  }
}

// ---- list of series ----

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
    VolumeSource source = open_part(slices, "the series", 1, series.damaged);
    require_one_value(series.folder, source.info);
    series.geometry = source.info.geometry;
    series.volumes = source.info.frames;
    series.warnings = source.info.warnings;
    if (series.volumes > 1)
      std::erase_if(series.warnings, [](const std::string& line) { return line.starts_with("4D: "); });
    if (!source.dicom.empty()) middle = &source.dicom[source.dicom.size() / 2];
    if (middle->unreadable.empty() && middle->pixels.samples == 1) series.preview = preview_of(*middle);
  } catch (const std::exception& exception) {
    const std::string text = exception.what();
    series.load_error = text.starts_with("cannot read ") && text.find(": ") != std::string::npos
                            ? text.substr(text.find(": ") + 2)
                            : text;
  }
  return series;
}

}  // namespace

bool is_dicomdir(const fs::path& path) { return lower_case(path.filename().string()) == "dicomdir"; }

FoundSeries find_dicom_series(const std::vector<fs::path>& paths) {
  const QuietLibraries quiet;
  FoundSeries found;
  std::vector<fs::path> files;
  const auto add_files = [&](std::vector<fs::path> more) { files.insert(files.end(), more.begin(), more.end()); };
  for (const fs::path& path : paths) {
    std::error_code error;
    if (fs::is_directory(path, error)) {
      add_files(files_in(path, true));
    } else if (is_dicomdir(path)) {
      require_file(path);
      add_files(files_of_dicomdir(path, found.unreadable));
    } else {
      files.push_back(path);
    }
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  const std::map<std::string, Slices> all = scan_files(files, found.unreadable);
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

VolumeSource open_named_series(const fs::path& folder, const std::string& uid, int volume) {
  const QuietLibraries quiet;
  std::vector<std::string> unreadable;
  for (const bool below : {false, true}) {
    std::map<std::string, Slices> all = scan_files(files_in(folder, below), unreadable);
    const auto found = all.find(uid);
    if (found == all.end()) continue;
    bool damaged = false;
    return open_part(std::move(found->second), "the DICOM series in " + quoted(folder), volume, damaged);
  }
  throw Error("cannot read " + quoted(folder), "it does not contain the series " + one_line(uid),
              "open the folder that contains the series");
}

VolumeSource open_only_series(const fs::path& path, int volume) {
  const QuietLibraries quiet;
  std::vector<std::string> unreadable;
  const bool disc = is_dicomdir(path);
  std::map<std::string, Slices> all =
      scan_files(disc ? files_of_dicomdir(path, unreadable) : files_in(path, true), unreadable);
  if (all.empty()) {
    throw Error("cannot read " + quoted(path),
                unreadable.empty() ? "neither it nor its subfolders contain DICOM images"
                                   : "no DICOM file in it can be read (" + unreadable.front() + ")",
                "choose a file or the folder of a series");
  }
  if (all.size() > 1) {
    constexpr std::size_t kMaxListed = 4;
    std::string list;
    std::size_t named = 0;
    for (const auto& [uid, slices] : all) {
      if (named++ == kMaxListed) break;
      const std::string& name = slices.front().description.empty() ? uid : slices.front().description;
      list.append(list.empty() ? "'" : ", '").append(one_line(name, 60)).append("' in ");
      list += quoted(common_folder(slices));
    }
    throw Error("cannot read " + quoted(path),
                "it contains " + std::to_string(all.size()) + " series (" + list +
                    (all.size() > kMaxListed ? " and others)" : ")"),
                "choose the folder of one series");
  }
  bool damaged = false;
  const std::string folder = quoted(common_folder(all.begin()->second));
  VolumeSource source = open_part(std::move(all.begin()->second), "the DICOM series in " + folder, volume, damaged);
  if (!disc) source.info.warnings.push_back("the series was found in the subfolder " + folder);
  return source;
}

}  // namespace simplexseg
