// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "evidence/marks.h"

namespace simplexseg {

/// The field P(object) of a mesh, and the marks that it was learned from. Immutable once made, so that undo can keep
/// what belonged to a scene.
struct MeshField {
  std::array<int, 3> first{}, size{};  ///< box of the volume's voxels
  std::vector<std::uint16_t> values;   ///< as FieldBox says (src/forces/step_view.h); empty: it could not be learned
  std::vector<Mark> marks;
  std::vector<Mark> others;  ///< inside marks of other meshes that reach the box: outside for this one
  bool leaks = false;        ///< the object reaches the far sides of the largest box
  std::string problem;       ///< why there are no values
};

}  // namespace simplexseg
