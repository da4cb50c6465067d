// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "gui/drawing/painters.h"
#include "gui/drawing/volume_texture.h"
#include "gui/look/view_state.h"

namespace simplexseg {

/// Painter of the volume by ray casting. Rays end at the depths of what is drawn already. Each frame calls update(),
/// take_depth(), and draw(InFront); with translucent surfaces, add_depth() and draw(Behind) before these are drawn.
class VolumePainter {
 public:
  enum class Part { Behind, InFront };

  void create();
  void destroy();
  /// Allocates and updates texture and images for a mode other than Off. `reduced`: for software renderers; only
  /// VolumeMode::Maximum, cast at reduced size, and only if camera, planes or volume have changed. Then a place with
  /// the largest value is hidden by what lies in front of it, and its ray does not end elsewhere.
  void update(const Projection& projection, const Volume& volume, const ViewState& view, CutEquations cut,
              bool reduced);
  /// Releases all memory, for VolumeMode::Off.
  void release();
  /// Memory of all textures.
  std::size_t bytes() const;

  /// Copies the depths of the current frame buffer, where rays end.
  void take_depth();
  /// Calls `draw`, which draws surfaces into a second copy of the depths.
  template <class Draw>
  void add_depth(const Draw& draw) {
    const int frame = begin_near_depth();
    draw();
    end_near_depth(frame);
  }
  /// Draws the volume: behind the surfaces of add_depth(), or in front of them, or, without them, everything.
  void draw(Part part) const;

 private:
  struct Image {
    unsigned frame = 0, texture = 0;
  };
  struct Camera {
    Eigen::Matrix4f clip_from_world = Eigen::Matrix4f::Zero();
    std::vector<Eigen::Vector4f> cut;
    bool operator==(const Camera&) const = default;
  };
  int begin_near_depth();
  void end_near_depth(int frame);
  void allocate(const Eigen::Vector2i& size_px);
  void release_images();
  void set_rays(const Projection& projection, CutEquations cut) const;
  void set_window(const ViewState& view) const;
  void cast_reduced(const Projection& projection) const;

  Program rays_, enlarge_;
  VolumeTexture texture_;
  unsigned vertex_array_ = 0;
  Eigen::Vector2i size_px_{0, 0}, reduced_px_{0, 0};
  Image far_, near_, maxima_;  ///< maxima_: largest values and their depths, for reduced images
  bool reduced_ = false, has_near_ = false;
  const void* shown_volume_ = nullptr;  ///< volume of maxima_; null: outdated
  Camera shown_;                        ///< camera of maxima_
};

}  // namespace simplexseg
