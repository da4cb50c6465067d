// SPDX-License-Identifier: Apache-2.0
// Image of a ring, which a mesh that starts as a sphere cannot reach by deformation.
#pragma once
#include "session_fixture.h"

namespace simplexseg {

/// Bright ring of radius 14 mm with a tube of radius 5 mm.
double depth_in_ring(const Eigen::Vector3d& mm);
using Depth = double (*)(const Eigen::Vector3d& mm);
/// Image of the object in which `depth` is positive, on the grid of the phantom.
Volume image_of(Depth depth);
Volume ring_image();
/// Mesh that starts as the sphere of a seed, with a field of the object, which covers the image and has no marks.
MeshItem item_with_field(const Volume& image, Depth depth, const Seed& seed);
/// Scene with one mesh "ring" that starts as a sphere in the ring and uses a field. With ring_marks(), the field is
/// correct, so that only the mesh is tested.
Scene ring_scene();
std::vector<Eigen::Vector3d> ring_marks();
/// ring_scene() with a field that need not be solved; the mesh has the id 1.
Scene solved_ring_scene();
int genus_of(const SimplexMesh& mesh);

}  // namespace simplexseg
