// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "io/segment_names.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// What of a label volume a mesh is to be made of.
struct LabelChoice {
  std::optional<double> label{};  ///< none: every voxel that is not 0
  int part = 0;                   ///< of its connected parts, 1 is the largest; 0: all of them
  std::string name{};             ///< what the file calls the label, in place of its number
};

/// A label of a volume.
struct LabelCount {
  double value = 0;
  std::string name;  ///< as its file says; empty where it does not
  std::optional<Colour> colour;
  std::size_t voxels = 0;
  double millilitres = 0;
};
/// The labels that a volume holds, by their values; of more than `most` those with the most voxels.
std::vector<LabelCount> count_labels(const Volume& labels, const std::vector<SegmentName>& names,
                                     std::size_t most = 1000);

struct ChosenLabel {
  Mask mask;
  std::vector<std::size_t> parts;  ///< voxels of each connected part of the label, the largest first
};

/// The voxels that are asked for; `name` is the volume's in messages. Throws Error when there is no such voxel or part,
/// saying which there are.
ChosenLabel choose_label(const Volume& labels, const LabelChoice& choice, const std::string& name);

}  // namespace simplexseg
