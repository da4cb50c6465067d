// SPDX-License-Identifier: Apache-2.0
// Paint: strokes of a brush that set voxels of an object exactly, above what its mesh and its field contain.
#pragma once
#include <memory>
#include <vector>

#include "image/mask.h"
#include "image/paint_stroke.h"
#include "session/scene.h"

namespace simplexseg {

/// Stroke of a point with UserPoint::brush.
PaintStroke paint_stroke_of(const UserPoint& point);
/// Strokes of the paint of a mesh, in the order in which they were drawn; later ones replace earlier ones.
std::vector<PaintStroke> paint_of(const Scene& scene, ItemId mesh);

/// Object of a mesh on a grid: the voxels inside its surface, changed by its paint. This is what labels contain.
Mask object_mask(const SimplexMesh& mesh, const std::vector<PaintStroke>& paint, const VolumeGeometry& grid);

/// Fraction of each voxel of a grid inside the surface of a mesh; 1 or 0 where it is painted.
std::vector<float> object_fractions(const SimplexMesh& mesh, const std::vector<PaintStroke>& paint,
                                    const VolumeGeometry& grid);

/// Field with paint: cells that paint covers are inside or outside. A cell that it covers in part (27 samples, for
/// cells larger than a voxel) has the mean of paint and field. The box is enlarged to contain the paint, up to 8
/// million cells. `solved`: field without paint; `volume`: its grid of voxels. Returns `solved` without paint or
/// without values.
std::shared_ptr<const MeshField> painted_field(std::shared_ptr<const MeshField> solved, std::vector<PaintStroke> paint,
                                               const VolumeGeometry& volume);

}  // namespace simplexseg
