// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "gui/drawing/painters.h"

namespace simplexseg {

/// Painter of cut faces: the parts of a cutting plane that lie inside a closed surface.
class CapPainter {
 public:
  /// Square of a cutting plane that covers everything that is drawn, and the image on it.
  struct Plane {
    Eigen::Vector4f equation{0, 0, 1, 0};
    Eigen::Vector3f corner_mm{0, 0, 0}, edge_u_mm{1, 0, 0}, edge_v_mm{0, 1, 0};
    bool faces_eye = true;                       ///< the eye is on the side that is removed
    const SceneBuffers::Slice* image = nullptr;  ///< null: no image
  };
  void create();
  void destroy();
  /// Draws the cut face of a mesh (index in the scene) in a plane, without the parts that `others`, the other planes in
  /// use, remove. Cut faces in one plane have equal depths: later ones cover earlier ones. Needs a cleared stencil
  /// buffer, and clears it again.
  void draw(const Projection& projection, const SceneBuffers& buffers, int mesh, const Plane& plane,
            CutEquations others, const Rgba& colour) const;

 private:
  void count_faces(const Projection& projection, const SceneBuffers& buffers, int mesh, const Plane& plane) const;
  void fill(const Projection& projection, const Plane& plane, CutEquations others, const Rgba& colour) const;

  Program count_, cap_;
  SurfaceArray surfaces_;
  unsigned vertex_array_ = 0;
};

}  // namespace simplexseg
