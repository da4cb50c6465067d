// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/colour.h"
#include "io/scene/layer_images.h"

namespace simplexseg {

/// Visible layers of a scene for pictures, blended as in the window (shaders/layer.frag).
class LayerPicture {
 public:
  LayerPicture() = default;
  /// Layers whose files are in `images`.
  LayerPicture(const Scene& scene, const LayerImages& images);
  /// Colour at a point of the volume, mm: `below` with the layers over it.
  Colour over(const Colour& below, const Eigen::Vector3d& world_mm) const;

 private:
  struct Shown {
    LayerItem item;
    std::shared_ptr<const Volume> image;
    Transform transform;
  };
  std::vector<Shown> layers_;
};

}  // namespace simplexseg
