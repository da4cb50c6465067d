// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// The segmentation that a scene's meshes make together.
struct LabelMap {
  Volume labels;                  ///< uint8, or uint16 where a label needs it; 0 outside every mesh
  std::size_t shared_voxels = 0;  ///< inside two or more meshes: that mesh has them whose field gives them the
                                  ///< larger P(object); the first of the scene where fields do not tell
};
/// Rasterises every mesh onto the grid with its own label. Throws Error for a label that is not in 1..65535 or a
/// geometry that is not valid.
LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry);

}  // namespace simplexseg
