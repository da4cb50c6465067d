// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/cap_painter.h"

#include <GL/glew.h>

namespace simplexseg {
namespace {
constexpr unsigned kAllBits = 0xFF, kFillBit = 1;  // kFillBit: stencil mask of begin_frame()
}

void CapPainter::create() {
  count_.create("cut.vert", "fill.frag");
  cap_.create("cap.vert", "cap.frag");
  surfaces_.create();
  glCreateVertexArrays(1, &vertex_array_);
}

void CapPainter::destroy() {
  count_.destroy();
  cap_.destroy();
  surfaces_.destroy();
  glDeleteVertexArrays(1, &vertex_array_);
  vertex_array_ = 0;
}

// Along a ray, every point of the plane inside a closed surface has one more face that leaves it than faces that enter
// it on the side that is kept (McReynolds and Blythe, Advanced graphics programming using OpenGL, 2005, 16.9).
void CapPainter::draw(const Projection& projection, const SceneBuffers& buffers, int mesh, const Plane& plane,
                      CutEquations others, const Rgba& colour) const {
  glEnable(GL_STENCIL_TEST);
  glStencilMask(kAllBits);
  count_faces(projection, buffers, mesh, plane);
  fill(projection, plane, others, colour);
  // The square resets the stencil wherever it is drawn. Counts remain where other planes remove it, and in all
  // directions if the eye is inside the surface.
  if (!others.empty() || !plane.faces_eye) glClear(GL_STENCIL_BUFFER_BIT);
  glStencilMask(kFillBit);
  glDisable(GL_STENCIL_TEST);
}

void CapPainter::count_faces(const Projection& projection, const SceneBuffers& buffers, int mesh,
                             const Plane& plane) const {
  count_.set("clip_from_world", projection.clip_from_world);
  count_.use();
  const CutScope cut(count_, {&plane.equation, 1});
  surfaces_.bind(buffers, false);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_DEPTH_CLAMP);  // faces nearer or farther than the depth range count too
  glStencilFunc(GL_ALWAYS, 0, kAllBits);
  glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_DECR_WRAP, GL_DECR_WRAP);
  glStencilOpSeparate(GL_BACK, GL_KEEP, GL_INCR_WRAP, GL_INCR_WRAP);
  draw_mesh_triangles(buffers, mesh);
  glDisable(GL_DEPTH_CLAMP);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void CapPainter::fill(const Projection& projection, const Plane& plane, CutEquations others, const Rgba& colour) const {
  cap_.set("clip_from_world", projection.clip_from_world);
  cap_.set("corner", plane.corner_mm);
  cap_.set("edge_u", plane.edge_u_mm);
  cap_.set("edge_v", plane.edge_v_mm);
  cap_.set("cap_colour", colour);
  cap_.set("image_share", plane.image ? 1.0f : 0.0f);
  if (plane.image) {
    const SliceGrid& grid = plane.image->grid;
    const Eigen::Vector3d corner = grid.corner_mm();
    const auto coordinate = [&](const Eigen::Vector3d& step_mm, int count) {
      const Eigen::Vector3d per_mm = step_mm / (step_mm.squaredNorm() * count);
      return Eigen::Vector4f(per_mm.cast<float>().homogeneous().cwiseProduct(
          Eigen::Vector4f(1, 1, 1, static_cast<float>(-per_mm.dot(corner)))));
    };
    cap_.set("image_u", coordinate(grid.step_u_mm, grid.width));
    cap_.set("image_v", coordinate(grid.step_v_mm, grid.height));
    glBindTextureUnit(0, plane.image->texture);
  }
  cap_.use();
  const CutScope cut(cap_, others);
  glBindVertexArray(vertex_array_);
  glStencilFunc(GL_NOTEQUAL, 0, kAllBits);
  glStencilOp(GL_KEEP, GL_ZERO, GL_ZERO);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(-1, -4);  // in front of a slice in the same plane
  if (colour.w() < 1) glDepthMask(GL_FALSE);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDepthMask(GL_TRUE);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

}  // namespace simplexseg
