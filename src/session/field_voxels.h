// SPDX-License-Identifier: Apache-2.0
// Voxels of marks, and values of the fields of meshes.
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

/// Sets the voxels of a ball, at least the one nearest to its centre, to `value` (1 or 0).
void paint_ball(Mask& mask, const Eigen::Vector3d& centre_mm, double radius_mm, std::uint8_t value);

/// Encoding of the values of a field (FieldBox in src/forces/step_view.h) for the voxels of a volume: within two voxels
/// of the object the probability, on the same side of the threshold as the voxel; beyond, the distance to the object.
FieldValue field_value_of(const VolumeGeometry& geometry);

/// Field of a mesh that starts from labels: its voxels at the start, corrected by the marks in their order. Inside and
/// outside marks are balls. A boundary mark adds or removes a ball that touches it, whose radius is the mark's distance
/// from the surface along its outward direction. `others`: inside marks of other meshes, background for this one. The
/// image is not used. Throws Error if no voxel is left.
MeshField field_of_start(const SimplexMesh& start, std::vector<Mark> marks, const std::vector<Mark>& others,
                         const VolumeGeometry& geometry, const RunJobs& run);

}  // namespace simplexseg
