// SPDX-License-Identifier: Apache-2.0
// What the views draw with: small owners of OpenGL 4.5 objects. All calls need the view's context to be current;
// objects are made by create() and given back by destroy(). Only painters*.cpp know OpenGL.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/scene.h"

namespace simplexseg {

struct SliceImage;
struct Surface;

using Rgba = Eigen::Vector4f;  ///< each 0..1
Rgba rgba_of(const Colour& colour, float alpha = 1);

/// Loads the OpenGL functions of the current context. Throws Error when they cannot be had.
void load_gl();
/// "Mesa llvmpipe ...", of the current context.
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
/// Leaves a state in which QPainter can write text.
void end_frame();

class Program {
 public:
  /// `name`: of NAME.vert and NAME.frag. Throws Error with the compiler's first line.
  void create(const char* name);
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

/// A slice as a textured quad in the patient frame.
class SlicePainter {
 public:
  void create();
  void destroy();
  /// Uploads the picture if it is not the one held.
  void update(const SliceImage& image);
  /// `show_black`: whether what the window makes black is drawn, or left open.
  void draw(const Projection& projection, const SliceImage& image, float low, float high, bool show_black) const;

 private:
  Program program_;
  unsigned texture_ = 0, vertex_array_ = 0;
  int width_ = 0, height_ = 0;
  std::uint64_t stamp_ = 0;
};

/// Thick, smooth line segments.
class LinePainter {
 public:
  void create();
  void destroy();
  void draw(const Projection& projection, std::span<const Eigen::Vector3f> ends_mm, const Rgba& colour, float width_px);

 private:
  Program program_;
  unsigned vertex_array_ = 0, buffer_ = 0;
};

/// Round handles.
class DiscPainter {
 public:
  struct Disc {
    Eigen::Vector3f centre_mm;
    Rgba fill, rim;
    float radius_px;
  };
  void create();
  void destroy();
  void draw(const Projection& projection, std::span<const Disc> discs);

 private:
  Program program_;
  unsigned vertex_array_ = 0, buffer_ = 0;
};

/// Shaded surfaces, one vertex buffer each.
class MeshPainter {
 public:
  void create();
  void destroy();
  /// Follows the surfaces: positions and normals always, triangles when they have changed.
  void update(std::span<const Surface> surfaces);
  /// `which`: index into the surfaces of update(). Opacity below 1 draws the back faces first.
  void draw(const Projection& projection, int which, const Rgba& colour);

 private:
  struct Buffers {
    unsigned vertex_array = 0, points = 0, normals = 0, indices = 0;
    int index_count = 0;
    std::uint64_t topology_stamp = 0;
  };
  static void release(Buffers& buffers);
  Program program_;
  std::vector<Buffers> buffers_;
};

}  // namespace simplexseg
