// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "image/volume.h"

namespace simplexseg {

/// Images of a field other than the volume of the scene, on the grid of that volume.
struct FieldImages {
  /// Image in which the field finds edges and surface; empty: the volume of the scene.
  Volume main{};
  /// Images that inform the prior in addition, by their appearance. Their effect: docs/results/README.md, "Several
  /// images".
  std::vector<Volume> further{};
};

}  // namespace simplexseg
