// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/error.h"
#include "forces/region_model.h"
#include "forces/step_view.h"
#include "image/volume.h"
#include "step/engine.h"

namespace simplexseg {

/// Sets size, geometry and intensity window of the view, except for the access to the voxels, which the executor sets.
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

/// Throws Error unless the box lies in the volume and has as many cells as the field has values. An empty field is
/// valid.
inline void check_field(const EngineField& field, const Volume& volume) {
  if (field.values.empty()) return;
  if (!field.box.lies_in(cell_geometry(volume.geometry(), field.cell).size) ||
      field.box.voxel_count() != field.values.size())
    throw Error("field of a mesh",
                "its box exceeds the volume, or the number of values differs from the number of cells",
                "pass one value for each cell of a box inside the volume");
}

}  // namespace simplexseg
