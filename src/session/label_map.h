// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Label volume of all meshes of a scene.
struct LabelMap {
  Volume labels;  ///< uint8, or uint16 if a label is above 255; 0 outside every mesh
  /// Number of overlaps: a voxel inside n >= 2 meshes counts n - 1 times. Of two meshes, the voxel gets the label of
  /// the one with the larger field value there; if a field is missing or the values are equal, that of the first in the
  /// scene. Voxels that paint puts into an object (session/paint.h) have its label in any case.
  std::size_t shared_voxels = 0;
};
/// Throws Error if the label of a mesh is outside 1 to 65535.
void require_label_numbers(const Scene& scene);
/// Rasterises every mesh, with its paint, with its label onto the grid. Throws Error for a label outside 1 to 65535 or
/// an invalid geometry.
LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry);
/// Label volume on a grid other than that of the volume, whose grid is `volume`.
LabelMap make_label_map(const Scene& scene, const VolumeGeometry& geometry, const VolumeGeometry& volume);

}  // namespace simplexseg
