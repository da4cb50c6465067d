// SPDX-License-Identifier: Apache-2.0
// Marks of a mesh: the prompts from which its field is solved.
#pragma once
#include <vector>

#include "field/evidence_settings.h"
#include "field/marks.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;
struct VolumeGeometry;

/// Marks of a mesh: its seed, then its points and strokes in the order in which they were placed. Paint, points and
/// parts of strokes outside the volume and boundary points without a direction are omitted.
std::vector<Mark> marks_of(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Seeds and inside points of the other meshes that use fields; these are background marks for this mesh.
std::vector<Mark> marks_of_others(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Marks of `others` whose balls reach the box of the field without paint; all of `others` if the field has no values.
std::vector<Mark> within_reach(std::vector<Mark> others, const MeshField& field, const VolumeGeometry& geometry);
/// Whether the mesh uses a field that has not been solved yet, or whose marks, or marks of other meshes that reach its
/// box, have changed since it was solved.
bool has_stale_field(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Present marks of the mesh, and those inside marks of others that reach the box of its field, for
/// MeshItem::cancelled.
CancelledUpdate cancelled_update(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Whether the field remains stale because the user cancelled its update (CancelFieldUpdate). False as soon as a mark
/// in CancelledUpdate has changed. Without a field, marks of other meshes do not matter: a new seed elsewhere must not
/// start again a solution that the user has stopped.
bool is_update_cancelled(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Whether the field must be solved: it is stale, and its update was not cancelled.
bool is_update_due(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Radius in mm of the ball of a new point: brush_radius_mm() in the field of the mesh, far_brush_radius_mm() without
/// a field. `fields`: settings of the fields.
double mark_radius_mm(const MeshItem& item, MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume,
                      const EvidenceSettings& fields = {});
/// Radius in mm of the balls of a new stroke: the smallest mark_radius_mm() of its vertices.
double stroke_radius_mm(const MeshItem& item, const UserPoint& stroke, const Volume& volume,
                        const EvidenceSettings& fields = {});
/// Unit direction out of the object at a new boundary point: the normal of the nearest vertex if that is less than one
/// voxel away; otherwise the direction from an inside point to the nearest vertex, or from the nearest vertex to an
/// outside point. 0 for a mesh without vertices.
Eigen::Vector3d outward_at(const MeshItem& item, const Eigen::Vector3d& position_mm, const Volume& volume);

}  // namespace simplexseg
