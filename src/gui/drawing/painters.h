// SPDX-License-Identifier: Apache-2.0
// Painters of the views. Each owns OpenGL 4.5 objects, which create() allocates and destroy() releases. All calls need
// the view's context to be current. Only sources of this folder use OpenGL (list in src/gui/CMakeLists.txt).
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gui/drawing/cut_scope.h"
#include "gui/drawing/scene_buffers.h"
#include "gui/look/point_style.h"
#include "session/scene.h"

class QColor;

namespace simplexseg {

using Rgba = Eigen::Vector4f;  ///< red, green, blue, alpha, each 0..1
Rgba rgba_of(const Colour& colour, float alpha = 1);
Rgba rgba_of(const QColor& colour, float alpha = 1);

/// Loads the OpenGL functions of the current context. Throws Error when they are unavailable.
void load_gl();
/// Name of the renderer of the current context, such as "llvmpipe ...".
std::string gl_renderer();
/// Whether the current context draws on the CPU.
bool is_software_renderer();

/// Projection of the world to the screen.
struct Projection {
  Eigen::Matrix4f clip_from_world = Eigen::Matrix4f::Identity();
  Eigen::Matrix4f eye_from_world = Eigen::Matrix4f::Identity();
  Eigen::Vector2f viewport_px{1, 1};  ///< device pixels
};

enum class Depth { Ignore, Test };
/// Clears the frame and sets the state that the painters expect.
void begin_frame(const Projection& projection, const Rgba& background);
void set_depth(Depth depth);
/// Restores the state that Qt expects.
void end_frame();

/// Shader program.
class Program {
 public:
  /// Compiles and links two shader files. Throws Error; for a compiler error, with the first line of its output.
  void create(const char* vertex, const char* fragment);
  void destroy();
  void use() const;
  void set(const char* uniform, const Eigen::Matrix4f& value) const;
  void set(const char* uniform, const Eigen::Vector4f& value) const;
  void set(const char* uniform, const Eigen::Vector3f& value) const;
  void set(const char* uniform, const Eigen::Vector2f& value) const;
  void set(const char* uniform, float value) const;
  void set(const char* uniform, std::span<const Eigen::Vector4f> values) const;

 private:
  int location(const char* uniform) const;
  unsigned program_ = 0;
};

/// Textured quad of a slice in the patient frame.
class SliceQuad {
 public:
  void create(const char* vertex, const char* fragment);
  void destroy();
  /// Shader program, whose further uniforms must be set before draw().
  const Program& program() const { return program_; }
  void draw(const Projection& projection, const SliceGrid& slice, unsigned texture) const;

 private:
  Program program_;
  unsigned vertex_array_ = 0;
};

/// Painter of the image of a slice.
class SlicePainter {
 public:
  void create();
  void destroy();
  /// `show_black`: draws black pixels; if false, they are transparent where their surroundings are black too.
  /// `tinted`: grey values, 0 to 1, that receive the tint, the first to the last; none if the first is larger.
  void draw(const Projection& projection, const SceneBuffers::Slice& slice, bool show_black, CutEquations cut = {},
            const std::array<float, 2>& tinted = {1, 0}, const Rgba& tint = {}) const;

 private:
  SliceQuad quad_;
  unsigned levels_ = 0;  ///< sampler of the coarser mipmap levels
};

/// Painter of a field (foreground probability) as a tint over a slice.
class FieldPainter {
 public:
  void create() { quad_.create("field.vert", "field.frag"); }
  void destroy() { quad_.destroy(); }
  void draw(const Projection& projection, const SliceGrid& slice, const SceneBuffers::Field& field,
            const Rgba& tint) const;

 private:
  SliceQuad quad_;
};

/// Painter of thick, smooth line segments.
class LinePainter {
 public:
  void create();
  void destroy();
  /// `ends_mm`: ends of the segments: start, end, start, end ... `width_px`: device pixels.
  void draw(const Projection& projection, std::span<const Eigen::Vector3f> ends_mm, const Rgba& colour, float width_px);

 private:
  Program program_;
  unsigned vertex_array_ = 0, buffer_ = 0;
};

/// Painter of round handles, with a dark edge for bright images. A handle has a white glyph or a broad rim.
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

/// Vertex array of the shared buffers in one context.
class SurfaceArray {
 public:
  void create();
  void destroy();
  /// `with_values`: binds SceneBuffers::values() too.
  void bind(const SceneBuffers& buffers, bool with_values) const;

 private:
  unsigned vertex_array_ = 0;
};

/// Draws the triangles of the mesh with index `mesh` in the scene; a SurfaceArray must be bound.
void draw_mesh_triangles(const SceneBuffers& buffers, int mesh);

/// Painter of shaded surfaces.
class MeshPainter {
 public:
  void create();
  void destroy();
  /// `mesh`: index in the scene. With an opacity below 1, back faces are drawn first. `most_mm`: if above 0, upper end
  /// of the colour scale for the values of the buffers, which then replace `colour`.
  void draw(const Projection& projection, const SceneBuffers& buffers, int mesh, const Rgba& colour, float most_mm = 0,
            CutEquations cut = {}) const;

 private:
  Program program_;
  SurfaceArray surfaces_;
};

/// Painter of the contours of the surfaces in a slice, as thick, smooth lines, and of their fill.
class OutlinePainter {
 public:
  void create();
  void destroy();
  /// Fills one mesh by the even-odd rule. The fill is not antialiased, because the contour covers its edge. Needs a
  /// cleared stencil buffer, and clears it again.
  void fill(const Projection& projection, const SceneBuffers::Outlines& outlines, int mesh, const Rgba& colour) const;
  /// `mesh`: index in the scene.
  void draw(const Projection& projection, const SceneBuffers::Outlines& outlines, int mesh, const Rgba& colour,
            float width_px) const;

 private:
  void draw_segments(const SceneBuffers::Outlines& outlines, int mesh) const;

  Program program_, count_, cover_;
  unsigned vertex_array_ = 0;
};

}  // namespace simplexseg
