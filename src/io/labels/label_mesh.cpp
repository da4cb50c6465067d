// SPDX-License-Identifier: Apache-2.0
#include "io/labels/label_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "core/error.h"
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
  std::ostringstream text;
  std::size_t count = 0;
  for (const double label : found) {
    if (count == kMaxNamed) break;
    text << (count++ ? ", " : "") << label;
  }
  if (found.size() > kMaxNamed) text << " and others";
  return text.str();
}

}  // namespace

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
      if (name.value == value) label.name = name.name, label.colour = name.colour;
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
    std::ostringstream missing;
    if (choice.label) missing << "no voxel has the label " << *choice.label;
    const std::string present = labels_in(labels);
    throw Error("cannot make a mesh from " + name, choice.label ? missing.str() : "all its voxels are 0",
                present.empty() ? "use a volume with labels" : "choose one of its labels: " + present);
  }
  if (choice.part < 0 || choice.part > static_cast<int>(parts.size())) {
    throw Error("cannot make a mesh from part " + std::to_string(choice.part) + " of " + name,
                "the labelled region has " + std::to_string(parts.size()) + " connected part(s)",
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
