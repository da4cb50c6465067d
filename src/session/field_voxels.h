// SPDX-License-Identifier: Apache-2.0
// Voxels in the balls of marks, and voxel values of the fields of meshes.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "field/field_value.h"
#include "field/run_jobs.h"
#include "image/mask.h"
#include "mesh/simplex_mesh.h"
#include "session/mesh_field.h"

namespace simplexseg {

/// Encoding of field values (FieldBox in src/forces/step_view.h) for a grid of voxels. Voxels of the object and voxels
/// within two smallest voxel spacings of it get the foreground probability, moved to the correct side of the threshold
/// if necessary. Voxels farther away get the encoded distance to the object.
FieldValue field_value_of(const VolumeGeometry& geometry);

/// Field of a mesh that starts from labels or a given mesh: the voxels inside `start`, corrected by the marks in their
/// order, without the first mark, which is the seed. Inside and outside marks are balls. A boundary mark adds or
/// removes a ball that touches the mark; the radius is the distance of the mark from the surface along its outward
/// axis, at least two voxels. `others`: inside marks of other meshes, which are background for this mesh. The image is
/// not used. Throws Error if no voxel remains.
MeshField field_of_start(const SimplexMesh& start, std::vector<Mark> marks, const std::vector<Mark>& others,
                         const VolumeGeometry& geometry, const RunJobs& run);

}  // namespace simplexseg
