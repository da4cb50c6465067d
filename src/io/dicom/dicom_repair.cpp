// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_repair.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

#include "io/dicom/dicom.h"
#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_position.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_segments.h"
#include "io/dicom/dicom_stack.h"

namespace simplexseg {
namespace {

using Slices = std::vector<DicomSlice>;

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

std::vector<double> values_of(const DicomSlice& slice) {
  std::vector<double> values(static_cast<std::size_t>(slice.pixels.rows) *
                             static_cast<std::size_t>(slice.pixels.columns));
  DicomFrames({slice}).read(slice, VoxelType::Float64, values.data());
  return values;
}

/// Returns true when two files contain the same image; false for frames of one file and for images with more than
/// kMaxComparedPixels, because a damaged header can claim any size.
bool are_copies(const DicomSlice& a, const DicomSlice& b) {
  constexpr std::int64_t kMaxComparedPixels = 1 << 24;
  if (a.file == b.file || a.pixels.samples != 1 || b.pixels.samples != 1 || !same_size(a, b)) return false;
  if (std::int64_t{a.pixels.rows} * a.pixels.columns > kMaxComparedPixels) return false;
  return a.traits == b.traits && values_of(a) == values_of(b);
}

/// Returns one slice for each set of copies. Adds the others to `omitted`.
Slices without_copies(Slices slices, Omitted& omitted) {
  if (slices.empty() || !slices.front().axes || !slices.front().position) return slices;
  const Eigen::Vector3d normal = slice_normal(slices.front());
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return std::tuple(place(a), a.file, a.frame) < std::tuple(place(b), b.file, b.frame);
  });
  const double tolerance = same_position_mm(slices);
  Slices copies, single;
  for (DicomSlice& s : slices) {
    const bool is_copy =
        !single.empty() && place(s) - place(single.back()) <= tolerance && are_copies(s, single.back());
    (is_copy ? copies : single).push_back(std::move(s));
  }
  omitted.add(copies, copies.size() == 1 ? "copy of another image" : "copies of other images");
  return single;
}

/// Returns the slices that belong to the volume. Returns all slices when an unreadable one could belong anywhere.
Slices usable_part(Slices slices, Omitted& omitted) {
  const auto unreadable =
      std::find_if(slices.begin(), slices.end(), [](const DicomSlice& s) { return !s.unreadable.empty(); });
  if (unreadable != slices.end()) {
    const std::string why = "unreadable: " + unreadable->unreadable;
    const bool placed = std::all_of(slices.begin(), slices.end(),
                                    [](const DicomSlice& s) { return s.unreadable.empty() || s.position; });
    if (!placed) return slices;
    slices = filter_slices(
        std::move(slices), [](const DicomSlice& s) { return s.unreadable.empty(); }, why, omitted);
  }
  slices = filter_slices(
      std::move(slices), [](const DicomSlice& s) { return s.position && s.axes; }, "without a position", omitted);
  slices = largest_group(std::move(slices), same_plane, "with another orientation", omitted);
  slices = largest_group(std::move(slices), same_size, "with another size or spacing", omitted);
  return without_copies(std::move(slices), omitted);
}

}  // namespace

VolumeSource open_repaired(const std::vector<DicomSlice>& slices, const std::string& series_name, int volume,
                           bool* repaired) {
  if (repaired) *repaired = false;
  try {
    return open_dicom_slices(slices, "DICOM series", series_name, volume);
  } catch (const Error&) {
    if (is_segmentation(slices.front())) throw;
    Omitted omitted;
    try {
      Slices part = usable_part(slices, omitted);
      const std::size_t loaded = part.size();
      if (omitted.count > 0 && 2 * loaded > slices.size()) {
        VolumeSource source = open_dicom_slices(std::move(part), "DICOM series", series_name, volume);
        std::string line =
            "only " + std::to_string(loaded) + " of " + std::to_string(slices.size()) + " slices are loaded; omitted: ";
        for (std::size_t n = 0; n < omitted.reasons.size(); ++n) line += (n > 0 ? ", " : "") + omitted.reasons[n];
        source.info.warnings.insert(source.info.warnings.begin(), line);
        if (repaired) *repaired = true;
        return source;
      }
    } catch (const Error&) {
      // The error of the whole series names all its faults.
    }
    throw;
  }
}

}  // namespace simplexseg
