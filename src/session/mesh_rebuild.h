// SPDX-License-Identifier: Apache-2.0
// Rebuilding of a mesh from the surface of its field, for surfaces that deformation cannot reach: because of another
// topology, processes that are too thin to enter, or a folded mesh. Reasons:
// docs/adr/0013-rebuild-meshes-from-fields.md.
#pragma once
#include <functional>
#include <optional>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Mismatch between a mesh and its field.
struct FieldMismatch {
  /// Voxels on the wrong side of the mesh whose foreground probability is above 0.7 or below 0.3, and voxels of the
  /// mesh outside the box of the field.
  int wrong = 0;
  int object = 0;  ///< number of voxels of the field's object
  /// Inside and outside marks whose centre is on the wrong side of the mesh, and painted cells that are, if all cells
  /// around them belong to the same side of the field.
  int wrong_marks = 0;
  int folded = 0;    ///< vertices whose normal is more than 90 degrees from a neighbour's normal
  int vertices = 0;  ///< number of vertices of the mesh

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

/// Called between the phases of a comparison and of a rebuild; throws to stop them. May be empty.
using StopCheck = std::function<void()>;

/// Mesh made from the surface of a field, and its derived quantities.
struct RebuiltMesh {
  SimplexMesh mesh;
  FieldMismatch mismatch;  ///< with the field
  float edge_mm = 0;
  std::vector<Vec4> shape;
};
/// Surface of the field of a mesh, with at most about twice the final number of vertices of the mesh, or 32 times if
/// fewer leave a mark on the wrong side. None if the field has no object or its surface gives no valid mesh.
std::optional<RebuiltMesh> surface_of_field(const MeshItem& item, const SimulationParameters& simulation,
                                            const Volume& volume, const StopCheck& check_stop = {});
/// Replaces the pose of a mesh, which then counts as on its finest level; discards its profiles and solver state.
void replace_mesh(MeshItem& item, RebuiltMesh rebuilt);
/// Replaces a mesh by surface_of_field(). Returns false, with nothing changed, if there is none.
bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);

/// Result of the comparison of a mesh with its field.
struct FieldComparison {
  FieldFit fit;
  std::optional<RebuiltMesh> rebuilt;  ///< mesh that replaces the compared one; none: the compared one remains
};
/// Compares a mesh with its field. If the mesh does not match the field and no longer approaches it, because it has
/// settled or its disagreement has hardly decreased since MeshItem::fit, the mesh is rebuilt if that is nearer to the
/// field. Reads mesh, field, fit and final number of vertices of `item`; depends on nothing else.
FieldComparison compare_and_rebuild(const MeshItem& item, bool settled, const SimulationParameters& simulation,
                                    const Volume& volume, const StopCheck& check_stop = {});

}  // namespace simplexseg
