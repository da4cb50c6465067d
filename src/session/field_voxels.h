// SPDX-License-Identifier: Apache-2.0
// What fields of meshes are made of: balls of marks as voxels, and the values of a field.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "evidence/field_value.h"
#include "evidence/run_jobs.h"
#include "image/mask.h"
#include "mesh/simplex_mesh.h"
#include "session/mesh_field.h"

namespace simplexseg {

/// Sets the voxels of a ball, at least its nearest one, to 1 or 0.
void paint_ball(Mask& mask, const Eigen::Vector3d& centre_mm, double radius_mm, std::uint8_t value);

/// How the values of a field (FieldBox in src/forces/step_view.h) are made, in a volume with these voxels: P(object) of
/// each, brought onto the side of the middle that it is on, and beyond two voxels from the object by the distance from
/// it.
FieldValue field_value_of(const VolumeGeometry& geometry);

/// The field of a mesh that starts from labels: its voxels at the start, corrected by the marks in their order. Inside
/// and outside marks are balls; a boundary mark adds, or takes away, a ball that touches it and is as wide as it lies
/// far from the surface along its way out. `others`: inside marks of other meshes, outside of this one. Nothing is
/// learned of the image. Throws Error where no voxel is left.
MeshField field_of_start(const SimplexMesh& start, std::vector<Mark> marks, const std::vector<Mark>& others,
                         const VolumeGeometry& geometry, const RunJobs& run);

}  // namespace simplexseg
