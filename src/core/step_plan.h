// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "core/scene.h"

namespace simplexseg {

class Volume;

/// What the step of a scene computes and holds, and what it leaves out and why.
struct StepPlan {
  struct Item {
    std::string name;          ///< of an array, a kernel or a per-refresh product
    std::string what;          ///< "array" or "kernel"
    bool needed;
    std::string why;           ///< it is needed, or left out
    std::size_t bytes = 0;     ///< that it holds (array) or reads and writes in one step (kernel)
  };
  std::vector<Item> items;
  /// Bytes of all needed arrays.
  std::size_t bytes_held() const;
};
StepPlan make_plan(const Scene& scene, const Volume& volume);

}  // namespace simplexseg
