// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_volumes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "io/dicom/dicom_frames.h"
#include "io/dicom/dicom_position.h"
#include "io/dicom/dicom_stack.h"

namespace simplexseg {
namespace {

/// Order of texts: numbers by value ("4.6" equals "4.60"), then all other texts in alphabetical order.
struct ByNumber {
  bool operator()(const std::string& a, const std::string& b) const {
    const std::optional<double> number_a = parse_number(a), number_b = parse_number(b);
    if (number_a && number_b) return *number_a < *number_b;
    return number_a.has_value() != number_b.has_value() ? number_a.has_value() : a < b;
  }
};

using Key = std::vector<std::string>;
struct ByKey {
  bool operator()(const Key& a, const Key& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), ByNumber());
  }
};
using Groups = std::map<Key, std::vector<std::size_t>, ByKey>;

std::string value_of(const DicomSlice& slice, const std::string& trait) {
  for (const auto& [name, value] : slice.traits) {
    if (name == trait) return value;
  }
  return {};
}

Groups groups_by(const std::vector<DicomSlice>& slices, const std::vector<std::string>& traits) {
  Groups groups;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    Key key;
    for (const std::string& trait : traits) key.push_back(value_of(slices[i], trait));
    groups[key].push_back(i);
  }
  return groups;
}

bool same_axes(const std::vector<DicomSlice>& slices) {
  return std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& s) { return same_plane(s, slices.front()); });
}

/// Returns the rank, from 0, of each slice's position along the normal; slices at one position have the same rank. All
/// ranks are 0 when a position is unknown.
std::vector<std::size_t> places_of(const std::vector<DicomSlice>& slices) {
  std::vector<std::size_t> places(slices.size(), 0);
  const bool placed =
      std::all_of(slices.begin(), slices.end(), [](const DicomSlice& s) { return s.position && s.axes; });
  if (!placed) return places;
  const Eigen::Vector3d normal = slice_normal(slices.front());
  const auto along = [&](std::size_t i) { return normal.dot(*slices[i].position); };
  std::vector<std::size_t> order(slices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return along(a) < along(b); });
  const double same_mm = same_position_mm(slices);
  for (std::size_t i = 1; i < order.size(); ++i)
    places[order[i]] = places[order[i - 1]] + (along(order[i]) - along(order[i - 1]) > same_mm ? 1 : 0);
  return places;
}

DicomVolumes volumes_of(const std::vector<DicomSlice>& slices, const Groups& groups,
                        const std::vector<std::string>& traits) {
  DicomVolumes result;
  for (const auto& [key, members] : groups) {
    auto& volume = result.volumes.emplace_back();
    for (const std::size_t i : members) volume.push_back(slices[i]);
    std::string name;
    for (std::size_t t = 0; t < traits.size(); ++t)
      name += (t > 0 ? ", " : "") + traits[t] + " " + (key[t].empty() ? "unknown" : key[t]);
    result.names.push_back(name);
  }
  return result;
}

/// Throws Error when a value that orders the volumes is not a number, e.g. "12,3".
void require_numbers(const std::vector<DicomSlice>& slices, const std::vector<std::string>& traits,
                     const std::string& series_name) {
  for (const std::string& trait : traits) {
    if (!is_numeric_trait(trait)) continue;
    for (const DicomSlice& slice : slices) {
      const std::string value = value_of(slice, trait);
      if (value.empty() || parse_number(value)) continue;
      std::string why = "its volumes differ in the ";
      why.append(trait).append(", which is '").append(value).append("', not a number");
      throw Error("cannot read " + series_name, why, "correct this value or export it again");
    }
  }
}

/// Returns all traits in which the slices differ.
std::vector<std::string> distinguishing_traits(const std::vector<DicomSlice>& slices) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const DicomSlice& s : slices) {
    for (const auto& [name, value] : s.traits) {
      if (seen.insert(name).second) names.push_back(name);
    }
  }
  std::erase_if(names, [&](const std::string& name) {
    const std::string first = value_of(slices.front(), name);
    return std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& s) { return value_of(s, name) == first; });
  });
  return names;
}

/// Returns true when instance numbers show that slices are missing: two neighbours in space are several slice distances
/// apart, and their instance numbers differ by as many.
bool has_lost_slices(std::vector<DicomSlice> slices) {
  const Eigen::Vector3d normal = slice_normal(slices.front());
  const auto place = [&](const DicomSlice& s) { return normal.dot(*s.position); };
  std::sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  std::vector<double> gaps;
  for (std::size_t i = 1; i < slices.size(); ++i) gaps.push_back(place(slices[i]) - place(slices[i - 1]));
  std::vector<double> sorted = gaps;
  std::erase_if(sorted, [tolerance = same_position_mm(slices)](double gap) { return gap <= tolerance; });
  if (sorted.empty()) return false;
  std::sort(sorted.begin(), sorted.end());
  const double spacing = sorted[(sorted.size() - 1) / 2];
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const auto from = slices[i].instance_number, to = slices[i + 1].instance_number;
    const double steps = std::round(gaps[i] / spacing);
    if (steps >= 2 && from && to && std::abs(*to - *from) == steps) return true;
  }
  return false;
}

constexpr std::size_t kMinSlices = 3;  ///< smallest pass: two slices are always evenly spaced

/// Splits slices that are not evenly spaced into passes; returns no volumes when they are none.
DicomVolumes passes_of(const std::vector<DicomSlice>& slices) {
  if (!std::all_of(slices.begin(), slices.end(), [](const DicomSlice& s) { return s.position && s.axes; })) return {};
  if (are_evenly_spaced(slices)) return {};
  for (const char* trait : {"stack", "acquisition number", "acquisition time"}) {
    const Groups groups = groups_by(slices, {trait});
    DicomVolumes passes = volumes_of(slices, groups, {trait});
    const auto is_pass = [](const std::vector<DicomSlice>& pass) {
      return pass.size() >= kMinSlices && are_evenly_spaced(pass);
    };
    const bool whole = groups.size() > 1 && std::all_of(passes.volumes.begin(), passes.volumes.end(), is_pass);
    if (!whole || has_lost_slices(slices)) continue;
    std::string list;
    for (std::size_t v = 0; v < passes.volumes.size(); ++v)
      list += (v > 0 ? ", " : "") + passes.names[v] + ": " +
              counted(static_cast<std::int64_t>(passes.volumes[v].size()), "slice");
    passes.note = "the series consists of " + std::to_string(passes.volumes.size()) +
                  " passes over different positions (" + list + "); each is a volume";
    return passes;
  }
  return {};
}

/// Returns the sets of traits to try: single traits, pairs, then all traits.
std::vector<std::vector<std::string>> candidates(const std::vector<std::string>& traits) {
  std::vector<std::vector<std::string>> sets;
  sets.reserve(traits.size());
  for (const std::string& trait : traits) sets.push_back({trait});
  for (std::size_t a = 0; a < traits.size(); ++a) {
    for (std::size_t b = a + 1; b < traits.size(); ++b) sets.push_back({traits[a], traits[b]});
  }
  if (traits.size() > 2) sets.push_back(traits);
  return sets;
}

}  // namespace

std::vector<double> times_of(const DicomVolumes& volumes) {
  std::vector<double> times;
  for (const std::string& name : volumes.names) {
    std::optional<double> ms;
    for (const std::string trait : {"trigger time ", "trigger delay ", "frame reference time "})
      if (name.starts_with(trait)) ms = parse_number(name.substr(trait.size()));
    if (!ms) return {};
    times.push_back(*ms / 1000);
  }
  return times;
}

DicomVolumes split_volumes(std::vector<DicomSlice> slices, const std::string& series_name) {
  if (!same_axes(slices)) {
    const Groups stacks = groups_by(slices, {"stack"});
    DicomVolumes split = volumes_of(slices, stacks, {"stack"});
    if (stacks.size() > 1 &&
        std::all_of(split.volumes.begin(), split.volumes.end(), [](const auto& v) { return same_axes(v); }))
      return split;
    return {{std::move(slices)}, {}, {}};
  }
  const std::vector<std::size_t> places = places_of(slices);
  const std::size_t count = *std::max_element(places.begin(), places.end()) + 1;
  const bool one_file = slices.front().file == slices.back().file;
  const bool unplaced = !slices.front().position && (!one_file || !slices.front().assumed.empty());
  if (unplaced) return {{std::move(slices)}, {}, {}};
  if (count == slices.size()) {
    DicomVolumes passes = passes_of(slices);
    return passes.volumes.empty() ? DicomVolumes{{std::move(slices)}, {}, {}} : passes;
  }
  for (const std::vector<std::string>& traits : candidates(distinguishing_traits(slices))) {
    const Groups groups = groups_by(slices, traits);
    const bool whole = groups.size() > 1 && std::all_of(groups.begin(), groups.end(), [&](const auto& group) {
                         std::set<std::size_t> seen;
                         for (const std::size_t i : group.second) seen.insert(places[i]);
                         return seen.size() == count && group.second.size() == count;
                       });
    if (!whole) continue;
    require_numbers(slices, traits, series_name);
    return volumes_of(slices, groups, traits);
  }
  if (DicomVolumes passes = passes_of(slices); !passes.volumes.empty()) return passes;
  std::vector<std::size_t> at(count, 0);
  for (const std::size_t place : places) ++at[place];
  if (at[0] > 1 && std::equal(at.begin() + 1, at.end(), at.begin())) {
    throw Error("cannot read " + series_name,
                "each of its " + std::to_string(count) + " positions has " + std::to_string(at[0]) +
                    " slices, and no attribute distinguishes their volumes (4D data or duplicates)",
                "move the slices of one volume to a separate folder");
  }
  return {{std::move(slices)}, {}, {}};
}

}  // namespace simplexseg
