// SPDX-License-Identifier: Apache-2.0
#include "session/free_attributes.h"

#include <algorithm>
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

int free_label(const Scene& scene) {
  return first_free(scene, [](const MeshItem& other, int label) { return other.label == label; });
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
