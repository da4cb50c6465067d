// SPDX-License-Identifier: Apache-2.0
// Display data, which an engine computes once per frame from its simulation arrays. The engine writes the data directly
// into OpenGL buffers where possible, otherwise into host memory that the window uploads.
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
  std::uint8_t inside;  ///< 255 inside the volume; 0 outside it and for NaN intensities
};

/// Sampling grid of a slice in voxel index space: texel (u, v) is centred at origin + u * step_u + v * step_v.
struct SlicePlane {
  Vec3 origin, step_u, step_v;
  int width = 0, height = 0;
  float low = 0, high = 1;  ///< intensities shown as black and as white; low > high inverts the grey scale
};

/// Segment of an outline: intersection of a plane with one triangle of a surface (24 bytes).
struct OutlineSegment {
  Vec3 start, end;  ///< mm
};
/// Arguments of glDrawArraysIndirect for the outline of one mesh: each segment is an instance of a triangle strip with
/// four corners.
struct OutlineCommand {
  std::uint32_t corners, segments, first_corner, first_segment;
};
/// Size of the output of draw_outlines, bytes: one command for each mesh, then space for one segment per vertex. The
/// segments of a mesh start at the index of its first vertex; a mesh draws at most as many segments as it has vertices.
inline constexpr std::size_t outline_bytes(std::size_t meshes, std::size_t vertices) {
  return meshes * sizeof(OutlineCommand) + vertices * sizeof(OutlineSegment);
}

/// Registration of an OpenGL buffer object that an engine writes on the device. It must be destroyed before the buffer
/// object, while the OpenGL context is current.
class SharedBuffer {
 public:
  virtual ~SharedBuffer() = default;
};

/// Destination of display data: `shared` if it is not null, otherwise `host`. Drawing throws Error if the destination
/// is too small.
template <class T>
struct DrawTarget {
  SharedBuffer* shared = nullptr;
  std::span<T> host;
};

}  // namespace simplexseg
