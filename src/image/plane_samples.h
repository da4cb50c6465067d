// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <span>

#include "image/transform.h"
#include "image/volume.h"

namespace simplexseg {

class ThreadPool;

/// Value of an image at a point, multiplied by `inside`: 1 within the image, 0 outside it and at values that are not
/// finite. Linear filtering of both and division interpolates up to the border.
struct PlaneSample {
  float value = 0, inside = 0;
};

/// Regular grid of points in a plane: row v, column u at origin_mm + u * step_u_mm + v * step_v_mm.
struct PlaneGrid {
  Eigen::Vector3d origin_mm{0, 0, 0}, step_u_mm{1, 0, 0}, step_v_mm{0, 1, 0};
  int width = 0, height = 0;
};

/// Values of an image at the transformed points of a grid, row by row, by trilinear interpolation; within half a voxel
/// of the border, that of the border. `samples`: width x height; `pool` shares the rows among its threads, which
/// changes no bit.
void sample_plane(const Volume& image, const Transform& transform, const PlaneGrid& grid,
                  std::span<PlaneSample> samples, ThreadPool& pool);

}  // namespace simplexseg
