// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "image/mask.h"
#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// A scene that methods are compared on.
struct StudyScene {
  std::string name;  ///< of files and titles
  Scene scene;
  Volume volume;
  std::vector<std::shared_ptr<const Mask>> truths;  ///< of each mesh; null: none
  bool frozen_from_start = false;                   ///< frozen targets are those of the start, not of the end
};

/// A sphere of 24 mm in 64^3 voxels of 1 mm that is to become an ellipsoid, at most 2 voxels away; gradient, weight
/// 0.5, without a bound of its pull, and an internal force of weight 5: kappa = 21 (docs/mathematics.md, section 3).
/// Full: shape memory of the sphere. Half: the image is constant for z < 0, so that half of the vertices have no data,
/// and the internal force is a plain Laplacian (smoothing without evenness or kept curvature), under which that half
/// becomes a membrane; there is no truth. `vertices`: rounded up to the next sphere.
StudyScene make_phantom_scene(bool half, int vertices);

}  // namespace simplexseg
