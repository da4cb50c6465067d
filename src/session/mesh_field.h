// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "evidence/marks.h"
#include "image/distance_map.h"

namespace simplexseg {

/// Foreground probability of a mesh's object in a box of voxels, and the marks that it was solved for. Immutable, so
/// that snapshots of a scene can share it.
struct MeshField {
  VoxelBox box{};                     ///< in voxels of the volume
  std::vector<std::uint16_t> values;  ///< encoded as in FieldBox (src/forces/step_view.h); empty: failed
  std::vector<Mark> marks;
  std::vector<Mark> others;  ///< inside marks of other meshes that reach the box: background for this one
  bool leaks = false;        ///< the object reaches the sides of the largest box
  float expected_dice = 1;   ///< EvidenceField::Report; 1 where the object comes from labels
  std::string problem;       ///< reason for the failure; empty: none

  /// Whether the segmentation is probably wrong: the expected Dice is low, for example if the seed lies in no object.
  /// Measured: true for none of 51 seeds in objects and for all of four in bowel
  /// (docs/results/archive/evidence-2026-11-23.md).
  bool probably_wrong() const { return expected_dice < 0.35f; }
  /// Whether the user must be warned about the field.
  bool needs_warning() const { return leaks || probably_wrong() || !problem.empty(); }

  /// Object mask of the box: 1 inside the object, else 0.
  std::vector<std::uint8_t> object_voxels() const;
};

}  // namespace simplexseg
