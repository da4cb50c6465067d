// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "evidence/marks.h"
#include "image/distance_map.h"

namespace simplexseg {

/// The field P(object) of a mesh, and the marks that it was learned from. Immutable once made, so that undo can keep
/// what belonged to a scene.
struct MeshField {
  VoxelBox box{};                     ///< of the volume's voxels
  std::vector<std::uint16_t> values;  ///< as FieldBox says (src/forces/step_view.h); empty: it could not be learned
  std::vector<Mark> marks;
  std::vector<Mark> others;  ///< inside marks of other meshes that reach the box: outside for this one
  bool leaks = false;        ///< the object reaches the far sides of the largest box
  float expected_dice = 1;   ///< EvidenceField::Report; 1 where the object was given, not learned
  std::string problem;       ///< why there are no values

  /// Whether next to nothing is known of the object: what was marked may not be one at all. Of 51 seeds in objects none
  /// is, of four in bowel all are (docs/results/evidence-2026-11-23.md).
  bool unsure() const { return expected_dice < 0.35f; }
  /// Whether the user is warned of it.
  bool doubted() const { return leaks || unsure() || !problem.empty(); }

  /// Of the box, 1 where the voxel is the object's, else 0.
  std::vector<std::uint8_t> object_voxels() const;
};

}  // namespace simplexseg
