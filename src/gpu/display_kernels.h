// SPDX-License-Identifier: Apache-2.0
// What only drawing needs, computed once a frame: normals of the present pose, cell centres, slices.
#pragma once
#include "core/display.h"
#include "core/sampling.h"
#include "gpu/kernels.h"

namespace simplexseg {

/// Position and normal of each vertex, in the order in which the meshes were loaded.
struct DrawVertices {
  static constexpr const char* name = "draw vertices";
  StepView v;
  const int* place;          ///< of each of the engine's vertices among the points
  DisplayPoint* points;
  SIMPLEXSEG_HD void operator()(int i) const {
    const Int4 nb = v.neighbours[i];
    const Vec3 p = xyz(v.current[i]), p1 = xyz(v.current[nb.x]);
    const Vec3 c = cross(xyz(v.current[nb.y]) - p1, xyz(v.current[nb.z]) - p1);
    const float length = norm(c);
    // Where the neighbours are collinear the simulation's last good normal serves.
    points[place[i]] = {with_w(p, 1.0f), with_w(length > 1e-18f ? (1.0f / length) * c : xyz(v.frame[i]), 0.0f)};
  }
};

/// Centre and mean normal of each cell, after the vertices.
struct DrawCells {
  static constexpr const char* name = "draw cells";
  const int* first;          ///< of each cell in `corners`, and their end
  const int* corners;        ///< points, cell by cell
  DisplayPoint* points;
  int vertex_count;
  SIMPLEXSEG_HD void operator()(int cell) const {
    Vec3 centre{0, 0, 0}, normal{0, 0, 0};
    const int begin = first[cell], end = first[cell + 1];
    for (int k = begin; k < end; ++k) {
      const DisplayPoint& p = points[corners[k]];
      centre = centre + xyz(p.position), normal = normal + xyz(p.normal);
    }
    const float length = norm(normal);
    const float each = end > begin ? 1.0f / (end - begin) : 0.0f;
    points[vertex_count + cell] = {with_w(each * centre, 1.0f), with_w((length > 0.0f ? 1.0f / length : 0.0f) * normal, 0.0f)};
  }
};

template <class Voxels>
struct DrawSlice {
  static constexpr const char* name = "draw slice";
  VolumeView volume;
  SlicePlane plane;
  DisplayTexel* texels;
  SIMPLEXSEG_HD void operator()(int n) const {
    const float u = static_cast<float>(n % plane.width), w = static_cast<float>(n / plane.width);
    const float intensity = Voxels(volume).sample(volume, plane.origin + u * plane.step_u + w * plane.step_v);
    const bool inside = is_valid(intensity);
    const float range = larger(plane.high - plane.low, 1e-30f);
    const float grey = inside ? smaller(larger((intensity - plane.low) / range, 0.0f), 1.0f) : 0.0f;
    texels[n] = {static_cast<std::uint8_t>(grey * 255.0f + 0.5f), static_cast<std::uint8_t>(inside ? 255 : 0)};
  }
};

}  // namespace simplexseg
