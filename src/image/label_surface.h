// SPDX-License-Identifier: Apache-2.0
// Closed 2-simplex meshes of labelled voxels.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Connected components of a mask as the offsets of their voxels, the largest first. Connectivity is that of
/// iso_surface(): across faces, and across those edges and corners that are crossed by an edge of its tetrahedra.
std::vector<std::vector<std::size_t>> connected_components(const Mask& mask);

/// Fills each cavity of at most `max_voxels` voxels; returns the number of filled cavities. A cavity is a component of
/// the background, connected as in connected_components(), that does not reach the outside.
int fill_cavities(Mask& mask, std::size_t max_voxels);

/// Smoothed mask on a box, with values from about 0 to 1 and background beyond the box. Smooths with a Gaussian of one
/// voxel standard deviation, sharpened so that curved faces keep their position to third order.
std::vector<float> smoothed_voxels(const std::vector<std::uint8_t>& set, const VoxelBox& box);

/// Surface of a mask as one simplex mesh in LPS mm, with one closed surface for each component and cavity and the genus
/// of the voxels. `vertices`: approximate vertex count, increased where the topology requires it; 0: triangle edges of
/// 1.25 voxels. Throws Error for an empty mask.
///
/// The mask is smoothed (smoothed_voxels()) such that no voxel centre changes sides. Its surface is extracted by
/// marching tetrahedra and remeshed (remesh()), and the vertices are projected onto the smoothed surface. They are then
/// moved by a common distance until the mesh has the volume of the voxels. Except in thin parts, all vertices lie
/// within half a voxel of the mask's boundary.
SimplexMesh mesh_of_mask(const Mask& mask, int vertices = 0);

/// Ball inside a mask.
struct InscribedBall {
  Eigen::Vector3d centre_mm;
  double radius_mm;  ///< distance from the centre to the nearest outside voxel, at least half a voxel
};
/// Approximate largest ball inside the mask, which must not be empty.
InscribedBall largest_inscribed_ball(const Mask& mask);

/// Number of closed surfaces of a mesh and the sum of their genera (number of handles).
struct Topology {
  int surfaces, genus;
};
Topology topology_of(const SimplexMesh& mesh);

}  // namespace simplexseg
