// SPDX-License-Identifier: Apache-2.0
// Closed 2-simplex meshes of what is labelled in a volume.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// The connected parts of a mask, each as the offsets of its voxels, the largest first; voxels belong together as
/// iso_surface() joins them: over faces, and over those edges and corners that its tetrahedra have an edge through.
std::vector<std::vector<std::size_t>> parts_of(const Mask& mask);

/// Sets the voxels of each cavity of at most `most` voxels: what is not set and no way leads to from outside, over
/// voxels that belong together as in parts_of(). Gives how many cavities that were.
int fill_cavities(Mask& mask, std::size_t most);

/// How much of the surroundings of each voxel of a box is set, between 0 and 1 or a little beyond: a Gaussian of one
/// voxel, sharpened so that curved faces stay where they are to the third order. Beyond the box nothing is set.
std::vector<float> smoothed_voxels(const std::vector<std::uint8_t>& set, const VoxelBox& box);

/// The surface of a mask as one simplex mesh in LPS mm, of as many closed surfaces as it has parts and cavities, each
/// of the genus of the voxels. The mask is smoothed (smoothed_voxels()) as far as no
/// voxel's centre changes sides, its surface found by marching tetrahedra, made even (remesh()), its vertices brought
/// onto the smoothed surface and moved together until the volume is that of the voxels; none ends farther than half a
/// voxel from the mask's boundary, thin parts excepted. `vertices`: about how many there are to be, but as many as the
/// topology needs; 0: triangles of one and a quarter voxels' length. Throws Error for a mask without a voxel.
SimplexMesh mesh_of_mask(const Mask& mask, int vertices = 0);

/// The largest ball (nearly) of voxels of the mask.
struct InnerBall {
  Eigen::Vector3d centre_mm;
  double radius_mm;  ///< distance of its centre from the nearest voxel outside, at least half a voxel
};
/// The mask must have a voxel.
InnerBall inner_ball(const Mask& mask);

/// Of the closed surfaces of a mesh: how many there are, and the sum of their genera (the holes through them).
struct Topology {
  int surfaces, genus;
};
Topology topology_of(const SimplexMesh& mesh);

}  // namespace simplexseg
