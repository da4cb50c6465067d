// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/colour.h"
#include "io/picture/picture_io.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Orthographic view of surfaces.
struct SurfaceView {
  /// Rotation from the patient frame to the view: rows are the directions to the right, up, and towards the viewer.
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();
  Eigen::Vector3f centre_mm{0, 0, 0};  ///< place at the centre of the picture
  float half_width_mm = 1;             ///< half of the smaller edge of the picture
};
/// View from the front of the patient, superior up; and from the left, anterior to the left.
Eigen::Matrix3f view_from_front();
Eigen::Matrix3f view_from_left();

/// Draws a closed surface, shaded by a light at the viewer, into a square of a picture: hidden parts by a depth buffer,
/// edges averaged from 2 x 2 samples. `colours`: of each vertex. `left`, `top`, `size`: the square, pixels, within the
/// picture.
void draw_surface(Picture& picture, int left, int top, int size, const TriangleMesh& surface,
                  const std::vector<Colour>& colours, const SurfaceView& view);

}  // namespace simplexseg
