// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// What the step of a scene computes and holds, and what it leaves out and why.
struct StepPlan {
  struct Item {
    std::string name;  ///< of an array, a kernel or a per-refresh product
    std::string what;  ///< "array" or "kernel"
    bool needed;
    std::string why;        ///< it is needed, or left out
    std::size_t bytes = 0;  ///< that it holds (array) or reads and writes in one step (kernel)
    bool operator==(const Item&) const = default;
  };
  std::vector<Item> items;
  /// Bytes of all needed arrays.
  std::size_t bytes_held() const;
  bool operator==(const StepPlan&) const = default;
};
StepPlan make_plan(const Scene& scene, const Volume& volume);
/// Voxels of a mesh's field; of one that is not learned yet those of a box of about four radii of its seed.
std::size_t expected_field_voxels(const MeshItem& item, const Volume& volume);
/// The same for what an engine was loaded with: which meshes are on their finest level, one entry each, and what is
/// held (the size of a hierarchy is known once it is made; before that it is estimated). Reads no pose.
StepPlan make_plan(const Scene& scene, const Volume& volume, std::span<const char> finest,
                   std::span<const Engine::HeldArray> held);

}  // namespace simplexseg
