// SPDX-License-Identifier: Apache-2.0
// Display data of an engine. The engine writes them once per frame from its simulation arrays, directly into OpenGL
// buffers where possible, otherwise into host memory that the window uploads.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/vec3.h"

namespace simplexseg {

/// Point of the tessellated surfaces, in the layout of the vertex shaders (32 bytes).
struct DisplayPoint {
  Vec4 position;  ///< mm; w = 1
  Vec4 normal;    ///< unit, outward; w = 0
};
/// Texel of a slice after window and level: the red and green channels of the texture.
struct DisplayTexel {
  std::uint8_t grey;
  std::uint8_t inside;  ///< 255 inside the volume; 0 outside and for NaN voxels
};

/// Sampling grid of a slice in voxel index space: texel (u, v) is centred at origin + u * step_u + v * step_v.
struct SlicePlane {
  Vec3 origin, step_u, step_v;
  int width = 0, height = 0;
  float low = 0, high = 1;  ///< intensities shown as black and white; `low` may exceed `high`
};

/// Segment of an outline: intersection of a plane with one triangle of a surface (24 bytes).
struct OutlineSegment {
  Vec3 start, end;  ///< mm
};
/// Arguments of glDrawArraysIndirect for the outline of one mesh; each segment is an instance of a four-corner strip.
struct OutlineCommand {
  std::uint32_t corners, segments, first_corner, first_segment;
};
/// Size of the output of draw_outlines: one command for each mesh, then one segment for each vertex. The segments of a
/// mesh start at its first vertex; those beyond its number of vertices are not drawn.
inline constexpr std::size_t outline_bytes(std::size_t meshes, std::size_t vertices) {
  return meshes * sizeof(OutlineCommand) + vertices * sizeof(OutlineSegment);
}

/// OpenGL buffer object that an engine writes on the device. Destroy it before the buffer, with the context current.
class SharedBuffer {
 public:
  virtual ~SharedBuffer() = default;
};

/// Destination of display data: the shared buffer if set, otherwise `host`, which must be large enough.
template <class T>
struct DrawTarget {
  SharedBuffer* shared = nullptr;
  std::span<T> host;
};

}  // namespace simplexseg
