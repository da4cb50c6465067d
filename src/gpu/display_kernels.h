// SPDX-License-Identifier: Apache-2.0
// Kernels that compute display data once per frame: normals of the current pose, cell centres, outlines, slices.
#pragma once
#include "core/atomics.h"
#include "forces/sampling.h"
#include "gpu/kernels.h"
#include "step/display.h"

namespace simplexseg {

/// Writes position and normal of each vertex, in the order of the loaded meshes.
struct DrawVertices {
  static constexpr const char* name = "draw vertices";
  StepView v;
  const int* place;  ///< index in `points` of each engine vertex
  DisplayPoint* points;
  SIMPLEXSEG_HD void operator()(int i) const {
    const Int4 nb = v.neighbours[i];
    const Vec3 p = xyz(v.current[i]), p1 = xyz(v.current[nb.x]);
    const Vec3 c = cross(xyz(v.current[nb.y]) - p1, xyz(v.current[nb.z]) - p1);
    const float length = norm(c);
    // If the neighbours are collinear, the normal from the last step is used.
    points[place[i]] = {with_w(p, 1.0f), with_w(length > 1e-18f ? (1.0f / length) * c : xyz(v.frame[i]), 0.0f)};
  }
};

/// Writes centre and mean normal (of length 1) of each cell after the vertices.
struct DrawCells {
  static constexpr const char* name = "draw cells";
  const int* first;    ///< index of the first corner of each cell in `corners`; last entry: number of corners
  const int* corners;  ///< engine vertices, cell by cell
  const int* place;
  DisplayPoint* points;
  int vertex_count;
  SIMPLEXSEG_HD void operator()(int cell) const {
    Vec3 centre{0, 0, 0}, normal{0, 0, 0};
    const int begin = first[cell], end = first[cell + 1];
    for (int k = begin; k < end; ++k) {
      const DisplayPoint& p = points[place[corners[k]]];
      centre = centre + xyz(p.position), normal = normal + xyz(p.normal);
    }
    const float length = norm(normal);
    const float each = end > begin ? 1.0f / (end - begin) : 0.0f;
    points[vertex_count + cell] = {with_w(each * centre, 1.0f),
                                   with_w((length > 0.0f ? 1.0f / length : 0.0f) * normal, 0.0f)};
  }
};

/// Writes the segments in which a plane intersects the triangles between the centre of each cell and its edges.
struct DrawOutlines {
  static constexpr const char* name = "draw outlines";
  StepView v;
  const int* first;
  const int* corners;
  int axis;
  float position_mm;
  OutlineCommand* commands;
  OutlineSegment* segments;
  SIMPLEXSEG_HD float height(Vec3 p) const { return (axis == 0 ? p.x : axis == 1 ? p.y : p.z) - position_mm; }
  SIMPLEXSEG_HD static Vec3 crossing(Vec3 a, float ha, Vec3 b, float hb) { return a + (ha / (ha - hb)) * (b - a); }
  SIMPLEXSEG_HD void operator()(int cell) const {
    const int begin = first[cell], end = first[cell + 1];
    if (begin >= end) return;
    Vec3 centre{0, 0, 0};
    bool above = false, below = false;
    for (int k = begin; k < end; ++k) {
      const Vec3 p = xyz(v.current[corners[k]]);
      centre = centre + p;
      if (height(p) >= 0.0f)
        above = true;
      else
        below = true;
    }
    if (!above || !below) return;
    centre = (1.0f / (end - begin)) * centre;
    const float hc = height(centre);
    const int mesh = v.neighbours[corners[begin]].w;
    Vec3 b = xyz(v.current[corners[end - 1]]);
    float hb = height(b);
    for (int k = begin; k < end; ++k) {
      const Vec3 a = b;
      const float ha = hb;
      b = xyz(v.current[corners[k]]), hb = height(b);
      // A corner on the plane counts as above it, so a triangle has either no crossing edge or two.
      const bool at = ha >= 0.0f, bt = hb >= 0.0f, ct = hc >= 0.0f;
      if (at == bt && bt == ct) continue;
      OutlineSegment segment;
      if (at == bt)
        segment = {crossing(centre, hc, a, ha), crossing(centre, hc, b, hb)};
      else if (at == ct)
        segment = {crossing(b, hb, centre, hc), crossing(b, hb, a, ha)};
      else
        segment = {crossing(a, ha, b, hb), crossing(a, ha, centre, hc)};
      const unsigned slot = atomic_add(&commands[mesh].segments, 1);
      if (slot < static_cast<unsigned>(v.meshes[mesh].vertex_count))
        segments[v.meshes[mesh].first_vertex + slot] = segment;
      else
        atomic_add(&commands[mesh].segments, -1);
    }
  }
};
/// Resets the draw command of each mesh.
struct BeginOutlines {
  static constexpr const char* name = "begin outlines";
  const MeshConstants* meshes;
  OutlineCommand* commands;
  SIMPLEXSEG_HD void operator()(int mesh) const {
    commands[mesh] = {4, 0, 0, static_cast<std::uint32_t>(meshes[mesh].first_vertex)};
  }
};

/// Writes the grey values of a slice through the volume.
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
    const float span = plane.high - plane.low;
    const float range = span < 0 ? smaller(span, -1e-30f) : larger(span, 1e-30f);
    const float grey = inside ? smaller(larger((intensity - plane.low) / range, 0.0f), 1.0f) : 0.0f;
    texels[n] = {static_cast<std::uint8_t>(grey * 255.0f + 0.5f), static_cast<std::uint8_t>(inside ? 255 : 0)};
  }
};

}  // namespace simplexseg
