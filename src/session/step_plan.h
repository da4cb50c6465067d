// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Plan of a step of a scene: all arrays and kernels, each with the reason why it is needed or omitted.
struct StepPlan {
  struct Item {
    std::string name;  ///< name of an array, or of a kernel of a step or a target refresh
    std::string what;  ///< "array" or "kernel"
    bool needed;
    std::string why;        ///< reason why it is needed or omitted
    std::size_t bytes = 0;  ///< array: size, bytes; kernel: bytes read and written in one step
    bool operator==(const Item&) const = default;
  };
  std::vector<Item> items;
  /// Bytes of all needed arrays.
  std::size_t bytes_allocated() const;
  bool operator==(const StepPlan&) const = default;
};
/// Plan of a scene that is not loaded yet, as if all fields were solved.
StepPlan make_plan(const Scene& scene, const Volume& volume);
/// Number of cells of a mesh's field. Before the field is solved, those of a box of four seed radii plus 20 voxels
/// along each axis, at most the volume and EvidenceSettings::max_cells.
std::size_t expected_field_cells(const MeshItem& item, const Volume& volume);
/// Plan of a scene that an engine has loaded. `finest`: per mesh, whether it is on its finest level; `allocated`:
/// arrays of the engine. The size of a multigrid hierarchy is estimated until the engine has allocated it. Downloads no
/// pose.
StepPlan make_plan(const Scene& scene, const Volume& volume, std::span<const char> finest,
                   std::span<const Engine::AllocatedArray> allocated);

}  // namespace simplexseg
