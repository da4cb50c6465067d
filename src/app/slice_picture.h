// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "app/layer_picture.h"
#include "image/volume.h"
#include "io/picture/picture_io.h"
#include "session/scene.h"

namespace simplexseg {

enum class SliceFrame { Volume, Objects };

/// Draws an axial, a sagittal and a coronal slice side by side, with the outlines of the visible meshes. Each of the
/// first four visible meshes has a row of slices through its centroid; without meshes, one row shows the centre of the
/// volume. Radiological convention: the patient's right is on the left, anterior and superior are up; sagittal:
/// anterior is on the left. `panel`: largest width and height of a panel, pixels. `low_is_bright` (MONOCHROME1) inverts
/// the greys. `layers`: drawn over the volume. `frame`: what the panels show; Objects: the visible meshes with a
/// margin, on white.
Picture draw_slices(const Volume& volume, const Scene& scene, bool low_is_bright = false, int panel = 400,
                    const LayerPicture& layers = {}, SliceFrame frame = SliceFrame::Volume);

}  // namespace simplexseg
