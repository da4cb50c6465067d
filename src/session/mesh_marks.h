// SPDX-License-Identifier: Apache-2.0
// What a scene says about the object of a mesh: its marks.
#pragma once
#include <vector>

#include "evidence/evidence_settings.h"
#include "evidence/marks.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;
struct VolumeGeometry;

/// The seed, then the mesh's points in the order in which they were placed. Boundary points that lie outside of the
/// volume mark nothing.
std::vector<Mark> marks_of(const Scene& scene, const MeshItem& item, const Volume& volume);
/// What is inside of the other meshes that take fields is outside of this one: their seeds and inside points.
std::vector<Mark> marks_of_others(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Of the marks of others those that reach the box of a field; all for a field without a box.
std::vector<Mark> within_reach(std::vector<Mark> others, const MeshField& field, const VolumeGeometry& geometry);
/// Whether the mesh's evidence comes from its marks, and these, or those of others that reach its field, have changed
/// since its field was learned.
bool has_stale_field(const Scene& scene, const MeshItem& item, const Volume& volume);
/// Radius in mm for the mark of a new point: brush_radius_mm() in the mesh's field, the least one without a field.
double mark_radius_mm(const MeshItem& item, MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume,
                      const EvidenceSettings& fields = {});
/// The way out of the object at a new boundary point, which draws the present surface to itself: from it to the surface
/// where it lies inside, else from the surface to it; along the surface's normal where it lies on it. 0 for a mesh
/// without vertices.
Eigen::Vector3d outward_at(const MeshItem& item, const Eigen::Vector3d& position_mm, const Volume& volume);

}  // namespace simplexseg
