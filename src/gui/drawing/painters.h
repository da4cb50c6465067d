// SPDX-License-Identifier: Apache-2.0
// What the views draw with: small owners of OpenGL 4.5 objects. All calls need the view's context to be current;
// objects are made by create() and given back by destroy(). Only painters.cpp, label_painter.cpp and scene_buffers.cpp
// know OpenGL.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gui/drawing/scene_buffers.h"
#include "gui/look/point_look.h"
#include "session/scene.h"

class QColor;

namespace simplexseg {

using Rgba = Eigen::Vector4f;  ///< each 0..1
Rgba rgba_of(const Colour& colour, float alpha = 1);
Rgba rgba_of(const QColor& colour, float alpha = 1);

/// Loads the OpenGL functions of the current context. Throws Error when they cannot be had.
void load_gl();
/// What draws in the current context: "Mesa llvmpipe ...".
std::string gl_renderer();

/// Where things go on the screen.
struct Projection {
  Eigen::Matrix4f clip_from_world = Eigen::Matrix4f::Identity();
  Eigen::Matrix4f eye_from_world = Eigen::Matrix4f::Identity();
  Eigen::Vector2f viewport_px{1, 1};  ///< device pixels
};

enum class Depth { Ignore, Test };
/// Clears the frame and sets the state that the painters expect.
void begin_frame(const Projection& projection, const Rgba& background);
void set_depth(Depth depth);
/// Leaves a state in which Qt can go on.
void end_frame();

class Program {
 public:
  /// Files of the shaders. Throws Error with the compiler's first line.
  void create(const char* vertex, const char* fragment);
  void destroy();
  void use() const;
  void set(const char* uniform, const Eigen::Matrix4f& value) const;
  void set(const char* uniform, const Eigen::Vector4f& value) const;
  void set(const char* uniform, const Eigen::Vector3f& value) const;
  void set(const char* uniform, const Eigen::Vector2f& value) const;
  void set(const char* uniform, float value) const;

 private:
  int location(const char* uniform) const;
  unsigned program_ = 0;
};

/// A texture on the quad of a slice in the patient frame.
class SliceQuad {
 public:
  void create(const char* vertex, const char* fragment);
  void destroy();
  /// Uniforms besides those of the quad are set through it before.
  const Program& program() const { return program_; }
  void draw(const Projection& projection, const SliceGrid& slice, unsigned texture) const;

 private:
  Program program_;
  unsigned vertex_array_ = 0;
};

/// The image of a slice.
class SlicePainter {
 public:
  void create();
  void destroy();
  /// `show_black`: whether what the window makes black is drawn, or left open where its surroundings are too.
  void draw(const Projection& projection, const SceneBuffers::Slice& slice, bool show_black) const;

 private:
  SliceQuad quad_;
  unsigned levels_ = 0;  ///< the sampler of coarser levels
};

/// A field P(object) as a tint over a slice.
class FieldPainter {
 public:
  void create() { quad_.create("field.vert", "field.frag"); }
  void destroy() { quad_.destroy(); }
  void draw(const Projection& projection, const SliceGrid& slice, const SceneBuffers::Field& field,
            const Rgba& tint) const;

 private:
  SliceQuad quad_;
};

/// Thick, smooth line segments.
class LinePainter {
 public:
  void create();
  void destroy();
  /// `ends_mm`: start, end, start, end ...
  void draw(const Projection& projection, std::span<const Eigen::Vector3f> ends_mm, const Rgba& colour, float width_px);

 private:
  Program program_;
  unsigned vertex_array_ = 0, buffer_ = 0;
};

/// Round handles with a dark edge, which shows on bright pictures. Without a glyph the rim is broad; a glyph is white.
class DiscPainter {
 public:
  struct Disc {
    Eigen::Vector3f centre_mm;
    Rgba fill, rim;
    float radius_px;
    Glyph glyph = Glyph::Plain;
  };
  void create();
  void destroy();
  void draw(const Projection& projection, std::span<const Disc> discs);

 private:
  Program program_;
  unsigned vertex_array_ = 0, buffer_ = 0;
};

/// Triangles of the shared buffers, as one context sees them.
class SurfaceArray {
 public:
  void create();
  void destroy();
  /// `with_values`: SceneBuffers::values() as well.
  void bind(const SceneBuffers& buffers, bool with_values) const;

 private:
  unsigned vertex_array_ = 0;
};

/// Shaded surfaces.
class MeshPainter {
 public:
  void create();
  void destroy();
  /// `mesh`: its place in the scene's list. Opacity below 1 draws the back faces first. `most_mm` above 0: coloured by
  /// the buffers' values, on a scale up to that, in place of `colour`.
  void draw(const Projection& projection, const SceneBuffers& buffers, int mesh, const Rgba& colour,
            float most_mm = 0) const;

 private:
  Program program_;
  SurfaceArray surfaces_;
};

/// Where a slice cuts the surfaces, as thick, smooth lines, and what these enclose.
class OutlinePainter {
 public:
  void create();
  void destroy();
  /// The inside of one mesh, by the even-odd rule; not antialiased, for its outline lies over its edge. Leaves the
  /// stencil buffer as it was.
  void fill(const Projection& projection, const SceneBuffers::Outlines& outlines, int mesh, const Rgba& colour) const;
  /// `mesh`: its place in the scene's list.
  void draw(const Projection& projection, const SceneBuffers::Outlines& outlines, int mesh, const Rgba& colour,
            float width_px) const;

 private:
  void draw_pieces(const SceneBuffers::Outlines& outlines, int mesh) const;

  Program program_, count_, cover_;
  unsigned vertex_array_ = 0;
};

}  // namespace simplexseg
