// SPDX-License-Identifier: Apache-2.0
// Rebuilds a mesh from the surface of its field if deformation cannot reach that surface: because of another topology,
// processes that are too thin to enter, or a folded mesh. Reasons: docs/adr/0013-rebuild-meshes-from-fields.md.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Mismatch of a mesh and its field.
struct FieldMismatch {
  int wrong = 0;        ///< voxels on the wrong side of the mesh whose foreground probability is above 0.7 or below 0.3
  int object = 0;       ///< voxels of the field's object
  int wrong_marks = 0;  ///< marks whose centre is on the wrong side of the mesh
  int folded = 0;       ///< vertices whose normal is more than 90 degrees from that of a neighbour
  int vertices = 0;     ///< vertices of the mesh

  /// Whether the mesh agrees with the field, apart from details smaller than its cells.
  bool matches() const { return wrong_marks == 0 && wrong <= 8 + object / 200 && folded <= 4 + vertices / 500; }
  int disagreement() const { return wrong + folded; }
  bool better_than(const FieldMismatch& other) const {
    return wrong_marks != other.wrong_marks ? wrong_marks < other.wrong_marks : disagreement() < other.disagreement();
  }
};
/// Compares a mesh, which must have a field, with that field.
FieldMismatch compare_with_field(const MeshItem& item, const Volume& volume);
/// Replaces a mesh by the surface of its field, settled on its finest level, with about its final number of vertices.
/// Returns false, with nothing changed, if the field has no object.
bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);

}  // namespace simplexseg
