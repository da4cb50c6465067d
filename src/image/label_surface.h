// SPDX-License-Identifier: Apache-2.0
// Closed 2-simplex meshes from labelled voxels.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Connected components of a mask as the offsets of their voxels, the largest component first. Two voxels are connected
/// if an edge of the tetrahedra of iso_surface() joins their centres: across faces and across some edges and corners.
std::vector<std::vector<std::size_t>> connected_components(const Mask& mask);

/// Fills each cavity of at most `max_voxels` voxels; returns the number of filled cavities. A cavity is a component of
/// the background, connected as in connected_components(), that is not connected to the outside.
int fill_cavities(Mask& mask, std::size_t max_voxels);

/// Smoothed mask on a box, with values from about 0 to 1; voxels beyond the box count as background. Smooths with a
/// Gaussian G of one voxel standard deviation, sharpened to 2 G - G G so that curved faces keep their position to third
/// order. `set`: one byte for each voxel of the box, 0 or 1.
std::vector<float> smoothed_voxels(const std::vector<std::uint8_t>& set, const VoxelBox& box);

/// Surface of a mask as one simplex mesh in LPS mm, with one closed surface for each component and cavity and the genus
/// of the voxels. `vertices`: approximate number of vertices, exceeded where the topology requires more; 0: the
/// number that results from triangle edges of 1.25 voxels. Throws Error for an empty mask.
///
/// The mask is smoothed (smoothed_voxels()) without moving any voxel centre across the surface. Its surface is
/// extracted by marching tetrahedra and remeshed (remesh()), and the vertices are projected onto the smoothed surface.
/// They are then moved by a common distance of up to 0.3 voxels to give the mesh the volume of the voxels. Except in
/// thin parts, all vertices lie within half a voxel of the mask's boundary.
SimplexMesh mesh_of_mask(const Mask& mask, int vertices = 0);

/// Ball inside a mask.
struct InscribedBall {
  Eigen::Vector3d centre_mm;
  double radius_mm;  ///< distance to the nearest outside voxel centre minus half a voxel; at least half a voxel
};
/// Approximation of the largest ball inside a mask, centred at a voxel. The mask must not be empty.
InscribedBall largest_inscribed_ball(const Mask& mask);

/// Number of closed surfaces of a mesh and the sum of their genera (number of handles).
struct Topology {
  int surfaces, genus;
};
Topology topology_of(const SimplexMesh& mesh);

}  // namespace simplexseg
