// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Label volume of all meshes of a scene.
struct LabelMap {
  Volume labels;  ///< uint8, or uint16 for labels above 255; 0 outside every mesh
  /// Number of voxels inside two or more meshes. Each gets the label of the mesh with the largest foreground
  /// probability there; without fields, or if the probabilities are equal, that of the first mesh.
  std::size_t shared_voxels = 0;
};
/// Rasterises every mesh onto the grid with its label. Throws Error for a label outside 1..65535 or an invalid
/// geometry.
LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry);

}  // namespace simplexseg
