// SPDX-License-Identifier: Apache-2.0
#include "session/free_attributes.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace simplexseg {
namespace {

constexpr Colour kPalette[] = {{230, 160, 60}, {86, 180, 233}, {0, 158, 115},   {240, 228, 66},  {204, 121, 167},
                               {213, 94, 0},   {0, 114, 178},  {170, 120, 240}, {120, 220, 180}, {240, 120, 120}};

std::string numbered_name(int number) { return "mesh " + std::to_string(number); }

}  // namespace

std::string free_name(const Scene& scene) {
  return numbered_name(
      first_free(scene, [](const MeshItem& other, int number) { return other.name == numbered_name(number); }));
}

bool is_default_name(const std::string& name) {
  constexpr std::string_view start = "mesh ";
  return name.starts_with(start) && name.size() > start.size() &&
         name.find_first_not_of("0123456789", start.size()) == std::string::npos;
}

std::string free_name(const Scene& scene, MeasurementKind kind) {
  for (int number = 1;; ++number) {
    std::string name = std::string(name_of(kind)) + " " + std::to_string(number);
    if (std::ranges::none_of(scene.measurements, [&](const Measurement& other) { return other.name == name; }))
      return name;
  }
}

int free_label(const Scene& scene) {
  std::set<int> used;
  for (const MeshItem& item : scene.meshes) used.insert(item.label);
  for (const auto& [name, label] : scene.labels.by_name) used.insert(label);
  int label = 1;
  while (used.contains(label)) ++label;
  return label;
}

int label_of_name(const Scene& scene, const std::string& name, ItemId mesh) {
  const auto found = scene.labels.by_name.find(name);
  if (found == scene.labels.by_name.end()) return 0;
  const bool taken = std::any_of(scene.meshes.begin(), scene.meshes.end(),
                                 [&](const MeshItem& item) { return item.id != mesh && item.label == found->second; });
  return taken ? 0 : found->second;
}

void set_labels(Scene& scene, LabelNumbers labels) {
  scene.labels = std::move(labels);
  const std::map<std::string, int>& by_name = scene.labels.by_name;
  std::set<int> reserved;
  for (const auto& [name, label] : by_name) reserved.insert(label);
  for (MeshItem& item : scene.meshes)
    if (const auto named = by_name.find(item.name); named != by_name.end()) item.label = named->second;
  for (MeshItem& item : scene.meshes)
    if (!by_name.contains(item.name) && reserved.contains(item.label)) item.label = free_label(scene);
}

Colour free_colour(std::span<const Colour> used) {
  return *std::ranges::min_element(kPalette, {}, [&](const Colour& one) { return std::ranges::count(used, one); });
}

Colour free_colour(const Scene& scene) {
  std::vector<Colour> used;
  for (const MeshItem& item : scene.meshes) used.push_back(item.colour);
  return free_colour(used);
}

}  // namespace simplexseg
