// SPDX-License-Identifier: Apache-2.0
// How well a surface sits in an image, and where it sits worst.
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "image/mask.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

class Volume;

/// Mean and standard deviation (of the population) of the voxels in a mask that are numbers.
struct Intensities {
  double mean, deviation;
  std::size_t voxels;
};
/// None where there is no such voxel. The mask is on the volume's grid.
std::optional<Intensities> intensities_in(const Volume& volume, const Mask& mask);

/// How far along its normal each vertex lies from the edge that the image has there, mm: where the intensity changes
/// most within four voxels to either side, nearer places preferred; four voxels where it changes by less than a fifth
/// of what it does at the middle one of the vertices. There must be a volume.
std::vector<float> edge_distances(const SimplexMesh& mesh, const Volume& volume);

/// A place of a surface, and what was measured there.
struct SurfacePlace {
  Eigen::Vector3d position_mm;
  float value;
};
/// The places with the largest values, the largest first, `count` at most, each a tenth of the mesh's extent from the
/// others. A value is the mean over a vertex and two rings about it, so that one vertex alone is no place. `values`:
/// one a vertex; those that are not finite count for nothing.
std::vector<SurfacePlace> worst_places(const SimplexMesh& mesh, std::span<const float> values, std::size_t count = 8);

}  // namespace simplexseg
