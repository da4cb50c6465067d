// SPDX-License-Identifier: Apache-2.0
// Rebuilding of a mesh from the surface of its field, for surfaces that deformation cannot reach: because of another
// topology, processes that are too thin to enter, or a folded mesh. Reasons:
// docs/adr/0013-rebuild-meshes-from-fields.md.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Mismatch between a mesh and its field.
struct FieldMismatch {
  int wrong = 0;        ///< voxels on the wrong side of the mesh whose foreground probability is above 0.7 or below 0.3
  int object = 0;       ///< number of voxels of the field's object
  int wrong_marks = 0;  ///< inside and outside marks whose centre is on the wrong side of the mesh
  int folded = 0;       ///< vertices whose normal is more than 90 degrees from a neighbour's normal
  int vertices = 0;     ///< number of vertices of the mesh

  /// Whether the mesh agrees with the field: no mark is on the wrong side, and at most a few voxels and vertices
  /// disagree, as details smaller than the cells cause.
  bool matches() const { return wrong_marks == 0 && wrong <= 8 + object / 200 && folded <= 4 + vertices / 500; }
  int disagreement() const { return wrong + folded; }
  bool better_than(const FieldMismatch& other) const {
    return wrong_marks != other.wrong_marks ? wrong_marks < other.wrong_marks : disagreement() < other.disagreement();
  }
};
/// Compares a mesh with its field, which must have been solved.
FieldMismatch compare_with_field(const MeshItem& item, const Volume& volume);
/// Replaces a mesh by the surface of its field, with at most about twice its final number of vertices, or 32 times if
/// fewer leave a mark on the wrong side. The mesh then counts as on its finest level; its profiles and solver state are
/// discarded. Returns false, with nothing changed, if the field has no object or its surface gives no valid mesh.
bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);

}  // namespace simplexseg
