// SPDX-License-Identifier: Apache-2.0
// A mesh that cannot come to where its field says the object is (another topology, processes too thin to be entered, a
// surface that has folded) is made anew of the field's surface. docs/adr/0013-meshes-made-of-fields.md says why.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// How far a mesh is from what its field says.
struct FieldDistance {
  int wrong = 0;   ///< voxels that the mesh has on the other side, though the field is sure of them: P > .7 or < .3
  int object = 0;  ///< voxels of the field's object
  int wrong_marks = 0;  ///< marks whose middle the mesh has on the wrong side
  int folded = 0;       ///< vertices whose normal makes more than a right angle with that of a neighbour
  int vertices = 0;     ///< of the mesh

  /// Whether the mesh is where the field says, but for what a surface of cells rounds off.
  bool follows() const { return wrong_marks == 0 && wrong <= 8 + object / 200 && folded <= 4 + vertices / 500; }
  int disagreement() const { return wrong + folded; }
  bool nearer_than(const FieldDistance& other) const {
    return wrong_marks != other.wrong_marks ? wrong_marks < other.wrong_marks : disagreement() < other.disagreement();
  }
};
/// Needs a field.
FieldDistance distance_to_field(const MeshItem& item, const Volume& volume);
/// Makes the mesh of the surface of its field, with about as many vertices as it is to end with, at rest and on its
/// finest level. False, with nothing changed, where the field has no object.
bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);

}  // namespace simplexseg
