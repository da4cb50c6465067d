// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "image/mask.h"
#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Scene for the comparison of methods.
struct StudyScene {
  std::string name;  ///< name in files and titles
  Scene scene;
  Volume volume;
  std::vector<std::shared_ptr<const Mask>> truths;  ///< reference mask of each mesh; null: none
  bool frozen_from_start = false;                   ///< whether the targets of the start are fixed, not of the end
};

/// Sphere of radius 24 mm in 64^3 voxels of 1 mm that should become an ellipsoid at most 2 voxels away. Forces:
/// gradient of weight 0.5 without a bound on its pull, and an internal force of weight 5; kappa = 21
/// (docs/mathematics.md, section 3). `half` = false: the internal force is shape memory of the sphere. `half` = true:
/// the image is constant for z < 0, so half of the vertices have no data; the internal force is a plain Laplacian
/// (smoothing without evenness or preserved curvature), which makes that half a membrane; there is no reference mask.
/// `vertices` is rounded up to the number of vertices of a sphere, 20 * 4^level.
StudyScene make_phantom_scene(bool half, int vertices);

}  // namespace simplexseg
