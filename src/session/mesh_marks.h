// SPDX-License-Identifier: Apache-2.0
// Marks of a mesh: its prompts in a scene.
#pragma once
#include <vector>

#include "evidence/evidence_settings.h"
#include "evidence/marks.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;
struct VolumeGeometry;

/// Seed of a mesh, then its points in the order in which they were placed. Points outside the volume and boundary
/// points without a direction are left out.
std::vector<Mark> marks_of(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Seeds and inside points of the other meshes that use fields; they are background marks for this mesh.
std::vector<Mark> marks_of_others(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Marks of other meshes that reach the box of a field; all of them for a field without a box.
std::vector<Mark> within_reach(std::vector<Mark> others, const MeshField& field, const VolumeGeometry& geometry);
/// Whether the mesh uses a field and its marks, or those of others that reach the field, have changed since the field
/// was solved.
bool has_stale_field(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Radius in mm of the ball of a new point: brush_radius_mm() in the mesh's field, least_brush_radius_mm() without one.
double mark_radius_mm(const MeshItem& item, MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume,
                      const EvidenceSettings& fields = {});
/// Unit direction out of the object at a new boundary point: from a point inside the current surface to the surface,
/// from the surface to a point outside, or along the normal if the point lies on the surface. 0 for a mesh without
/// vertices.
Eigen::Vector3d outward_at(const MeshItem& item, const Eigen::Vector3d& position_mm, const Volume& volume);

}  // namespace simplexseg
