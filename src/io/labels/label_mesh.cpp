// SPDX-License-Identifier: Apache-2.0
#include "io/labels/label_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "image/label_surface.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxNamed = 12;
constexpr std::size_t kMaxLabels = 65535;

/// List of labels in a volume for messages, for example "1, 2, 5 and others".
std::string labels_in(const Volume& labels) {
  std::set<double> found;
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    for (const T v : labels.voxels<T>())
      if (v != T(0) && v == v && found.size() <= kMaxNamed) found.insert(static_cast<double>(v));
  });
  std::string text;
  std::size_t count = 0;
  for (const double label : found) {
    if (count == kMaxNamed) break;
    text += (count++ ? ", " : "") + exact_text(label);
  }
  if (found.size() > kMaxNamed) text += " and others";
  return text;
}

/// Voxels of a floating-point volume that are not exactly whole.
struct Fractions {
  std::size_t rounded = 0, fractions = 0;  ///< number of voxels within the tolerance, and beyond it
  double example = 0;                      ///< first voxel beyond the tolerance
};

template <class T>
Fractions fractions_of(std::span<const T> voxels) {
  constexpr double kWhole = 1e-3, kWholeShare = 1e-6;
  Fractions found;
  for (const T v : voxels) {
    const double value = static_cast<double>(v), whole = std::round(value);
    if (value == whole ? std::isfinite(value) : std::isnan(value)) continue;
    if (std::abs(value - whole) <= std::max(kWhole, kWholeShare * std::abs(value)))
      ++found.rounded;
    else if (found.fractions++ == 0)
      found.example = value;
  }
  return found;
}

/// Sets voxels of at least `threshold` to `label`, all others to 0.
template <class T>
void label_from(std::span<T> voxels, double threshold, double label, const std::string& name) {
  double largest = -std::numeric_limits<double>::infinity();
  for (T& v : voxels) {
    const double value = static_cast<double>(v);
    if (value > largest) largest = value;
    v = value >= threshold ? static_cast<T>(label) : T(0);
  }
  if (largest >= threshold) return;
  throw Error(
      "cannot use " + name + " as labels",
      "no voxel reaches the threshold " + exact_text(threshold) + ", the largest value is " + exact_text(largest),
      "choose a smaller threshold");
}

}  // namespace

void make_whole_labels(Volume& labels, const LabelChoice& choice, const std::string& name,
                       std::vector<std::string>& warnings) {
  Fractions found;
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_floating_point_v<T>) {
      const std::span<T> voxels = labels.voxels<T>();
      found = fractions_of<T>(voxels);
      if (found.fractions > 0 && choice.threshold)
        label_from(voxels, *choice.threshold, choice.label.value_or(1), name);
      if (found.fractions == 0 && found.rounded > 0)
        for (T& v : voxels) v = std::round(v);
    }
  });
  if (found.fractions > 0 && !choice.threshold) {
    throw Error("cannot use " + name + " as labels",
                "it is not labels: " +
                    counted(static_cast<std::int64_t>(found.fractions), "voxel is not a whole number",
                            "voxels are not whole numbers") +
                    ", for example " + general_text(found.example, 6),
                "use a label volume, or choose a threshold (--threshold 0.5)");
  }
  if (found.fractions > 0) return;
  if (found.rounded > 0)
    warnings.push_back(counted(static_cast<std::int64_t>(found.rounded),
                               "voxel is not exactly a whole number and is rounded to a label",
                               "voxels are not exactly whole numbers and are rounded to labels"));
  const bool changes = choice.threshold && !(*choice.threshold > 0 && *choice.threshold <= 1);
  if (changes && !choice.label && choice.name.empty())
    warnings.push_back("all voxels are whole numbers and count as labels: the threshold " +
                       exact_text(*choice.threshold) + " is not applied");
}

std::vector<LabelCount> count_labels(const Volume& labels, const std::vector<SegmentName>& names,
                                     std::size_t max_labels) {
  std::map<double, std::size_t> counts;
  visit_voxel_type(labels.type(), [&]<class T>(std::type_identity<T>) {
    double last = 0;
    std::size_t* count = nullptr;  // cache: neighbouring voxels usually have the same label
    for (const T v : labels.voxels<T>()) {
      const double value = static_cast<double>(v);
      if (v == T(0) || v != v) continue;
      if (!count || value != last) count = &counts[last = value];
      if (counts.size() > kMaxLabels)
        throw Error("cannot list the labels",
                    "the volume has more than " + std::to_string(kMaxLabels) + " different values",
                    "use a label volume, not an image");
      ++*count;
    }
  });
  const VolumeGeometry& geometry = labels.geometry();
  const double voxel_ml = std::abs(geometry.direction.determinant()) * geometry.spacing_mm.prod() / 1000;
  std::vector<LabelCount> result;
  for (const auto& [value, voxels] : counts) {
    LabelCount& label = result.emplace_back();
    label.value = value, label.voxels = voxels, label.millilitres = static_cast<double>(voxels) * voxel_ml;
    for (const SegmentName& name : names)
      if (name.value == value) label.name = name.name, label.colour = name.colour, label.code = name.code;
  }
  if (result.size() > max_labels) {
    std::nth_element(result.begin(), result.begin() + static_cast<std::ptrdiff_t>(max_labels), result.end(),
                     [](const LabelCount& a, const LabelCount& b) { return a.voxels > b.voxels; });
    result.resize(max_labels);
    std::sort(result.begin(), result.end(), [](const LabelCount& a, const LabelCount& b) { return a.value < b.value; });
  }
  return result;
}

ChosenLabel choose_label(const Volume& labels, const LabelChoice& choice, const std::string& name) {
  ChosenLabel chosen{mask_of(labels, choice.label), {}};
  const std::vector<std::vector<std::size_t>> parts = connected_components(chosen.mask);
  if (parts.empty()) {
    const std::string present = labels_in(labels);
    throw Error("cannot make a mesh from " + name,
                choice.label ? "no voxel has the label " + exact_text(*choice.label) : "all its voxels are 0",
                present.empty() ? "use a volume with labels" : "choose one of its labels: " + present);
  }
  if (choice.part < 0 || choice.part > static_cast<int>(parts.size())) {
    throw Error("cannot make a mesh from part " + std::to_string(choice.part) + " of " + name,
                "the labelled region has " + counted(static_cast<std::int64_t>(parts.size()), "connected part"),
                "choose a part from 1 (the largest) to " + std::to_string(parts.size()));
  }
  for (const auto& part : parts) chosen.parts.push_back(part.size());
  if (choice.part > 0) {
    std::fill(chosen.mask.voxels.begin(), chosen.mask.voxels.end(), 0);
    for (const std::size_t v : parts[static_cast<std::size_t>(choice.part) - 1]) chosen.mask.voxels[v] = 1;
  }
  return chosen;
}

}  // namespace simplexseg
