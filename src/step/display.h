// SPDX-License-Identifier: Apache-2.0
// What a window draws of an engine's state. The engine writes it once a frame, from the arrays that it simulates on,
// straight into OpenGL buffers where it can, else into host memory that the window uploads.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/vec3.h"

namespace simplexseg {

/// A point of the tessellated surfaces: 32 bytes, as the vertex shaders read it.
struct DisplayPoint {
  Vec4 position;  ///< mm; w = 1
  Vec4 normal;    ///< unit, outward; w = 0
};
/// A texel of a slice after window and level: 2 bytes, red and green of the texture.
struct DisplayTexel {
  std::uint8_t grey;
  std::uint8_t inside;  ///< 255 inside the volume, 0 outside and where the voxel is not a number
};

/// The texels of a slice in voxel index space: texel (u, v) is centred at origin + u * step_u + v * step_v.
struct SlicePlane {
  Vec3 origin, step_u, step_v;
  int width = 0, height = 0;
  float low = 0, high = 1;  ///< intensities that become black and white; `low` can be the greater one
};

/// A piece of an outline, where a plane cuts one triangle of a surface: 24 bytes.
struct OutlinePiece {
  Vec3 start, end;  ///< mm
};
/// How OpenGL draws the outline of one mesh, every piece an instance of a strip of four corners (glDrawArraysIndirect).
struct OutlineCommand {
  std::uint32_t corners, pieces, first_corner, first_piece;
};
/// What draw_outlines writes: a command for each mesh, then room for as many pieces as there are vertices, each mesh's
/// from its first vertex on. A plane that cuts more triangles of a mesh than it has vertices shows the first ones.
inline constexpr std::size_t outline_bytes(std::size_t meshes, std::size_t vertices) {
  return meshes * sizeof(OutlineCommand) + vertices * sizeof(OutlinePiece);
}

/// A buffer object of OpenGL that an engine writes on the device. Destroy it with the context current, before the
/// buffer.
class SharedBuffer {
 public:
  virtual ~SharedBuffer() = default;
};

/// Where an engine draws: the shared buffer when there is one, else `host`, which must be large enough.
template <class T>
struct DrawTarget {
  SharedBuffer* shared = nullptr;
  std::span<T> host;
};

}  // namespace simplexseg
