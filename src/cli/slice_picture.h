// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "image/volume.h"
#include "io/picture_io.h"
#include "session/scene.h"

namespace simplexseg {

/// An axial, a sagittal and a coronal slice side by side, with the outlines of the visible meshes where the planes cut
/// them: one row for each visible mesh (four at most), through its centroid; through the volume's centre where there is
/// none. Radiological: the patient's right is on the left, anterior and superior are up; sagittal: anterior on the
/// left. Panels are `panel` pixels wide and high at most. With `low_is_bright` (MONOCHROME1) the greys are inverted.
Picture draw_slices(const Volume& volume, const Scene& scene, bool low_is_bright = false, int panel = 400);

}  // namespace simplexseg
