// SPDX-License-Identifier: Apache-2.0
// Measures the fit of a surface to the edges of an image and finds the positions of the poorest fit.
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

/// Mean and population standard deviation of the finite voxels in a mask.
struct Intensities {
  double mean, deviation;
  std::size_t voxels;
};
/// Statistics of the voxels in a mask on the volume's grid; nullopt without a finite voxel.
std::optional<Intensities> intensities_in(const Volume& volume, const Mask& mask);

/// Distance (mm) of each vertex along its normal to the strongest image edge within four voxels; near edges are
/// preferred. The result is four voxels where the edge is weaker than a fifth of the median over the vertices. The
/// volume must not be empty.
std::vector<float> edge_distances(const SimplexMesh& mesh, const Volume& volume);

/// Position on a surface and a value measured there.
struct SurfaceLocation {
  Eigen::Vector3d position_mm;
  float value;
};
/// Positions of the largest values, the largest first: at most `count`, at least a tenth of the mesh's largest extent
/// apart. Values are averaged over neighbours in two passes, which suppresses outliers at single vertices. `values`:
/// one per vertex; values that are not finite count as 0.
std::vector<SurfaceLocation> worst_locations(const SimplexMesh& mesh, std::span<const float> values,
                                             std::size_t count = 8);

}  // namespace simplexseg
