// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "forces/region_model.h"
#include "forces/step_view.h"
#include "image/volume.h"

namespace simplexseg {

/// What kernels know of a volume besides where its voxels are, which an executor says: size, place and usual
/// intensities.
inline void describe(const Volume& volume, VolumeView& view) {
  const VolumeGeometry& g = volume.geometry();
  const Eigen::Matrix<double, 3, 4> m = g.index_from_world().matrix().topRows<3>();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) view.index_from_world[4 * r + c] = static_cast<float>(m(r, c));
  for (int k = 0; k < 3; ++k) view.size[k] = g.size[k];
  const IntensityWindow window = intensity_window(volume);
  view.intensity_low = static_cast<float>(window.low);
  view.intensity_scale = static_cast<float>(1.0 / (window.high - window.low));
}

}  // namespace simplexseg
