// SPDX-License-Identifier: Apache-2.0
#include "gui/look/view_state.h"

namespace simplexseg {

Eigen::Vector3d slice_through_mm(const ViewState& view, const VolumeGeometry& geometry, Orientation orientation,
                                 int neighbour) {
  Eigen::Vector3d at = view.crosshair_mm;
  const int normal = slice_axes(orientation, Convention::Radiological).normal;
  if (neighbour != 0) at[normal] += neighbour * view.neighbour_step * slice_spacing_mm(geometry)[normal];
  return at;
}

}  // namespace simplexseg
