// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// What of a label volume a mesh is to be made of.
struct LabelChoice {
  std::optional<double> label;  ///< none: every voxel that is not 0
  int part = 0;                 ///< of its connected parts, 1 is the largest; 0: all of them
};

struct ChosenLabel {
  Mask mask;
  std::vector<std::size_t> parts;  ///< voxels of each connected part of the label, the largest first
};

/// The voxels that are asked for; `name` is the volume's in messages. Throws Error when there is no such voxel or part,
/// saying which there are.
ChosenLabel choose_label(const Volume& labels, const LabelChoice& choice, const std::string& name);

}  // namespace simplexseg
