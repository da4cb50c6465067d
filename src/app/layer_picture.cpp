// SPDX-License-Identifier: Apache-2.0
#include "app/layer_picture.h"

#include <algorithm>
#include <cmath>

namespace simplexseg {
namespace {

/// Colour of a map, 0 to 1. `share`: place of the value in the window, 0 to 1.
Eigen::Array3d colour_of(ColourMap map, double share) {
  switch (map) {
    case ColourMap::Grey:
      break;
    case ColourMap::InvertedGrey:
      return Eigen::Array3d::Constant(1 - share);
    case ColourMap::Hot:
      return (Eigen::Array3d(8.0 / 3, 8.0 / 3, 4) * share - Eigen::Array3d(0, 1, 3)).max(0).min(1);
    case ColourMap::Green:
      return {0, share, 0};
    case ColourMap::Magenta:
      return {share, 0, share};
  }
  return Eigen::Array3d::Constant(share);
}

}  // namespace

LayerPicture::LayerPicture(const Scene& scene, const LayerImages& images) {
  for (const LayerItem& item : scene.layers) {
    std::shared_ptr<const Volume> image = images.image_of(item);
    if (item.visible && image && images.has_transform(item))
      layers_.push_back({item, std::move(image), images.transform_of(item)});
  }
}

Colour LayerPicture::over(const Colour& below, const Eigen::Vector3d& world_mm) const {
  Eigen::Array3d mixed(below.red, below.green, below.blue);
  for (const auto& [item, image, transform] : layers_) {
    const Eigen::Vector3d at = transform(world_mm);
    if (!at.allFinite() || !image->geometry().contains(at)) continue;
    const double value = item.scale * image->sample(at);
    if (!std::isfinite(value)) continue;
    const double share = std::clamp((value - item.level) / item.window + 0.5, 0.0, 1.0);
    // Low values of a coloured map are transparent.
    const bool fades = item.colour_map != ColourMap::Grey && item.colour_map != ColourMap::InvertedGrey;
    const double opacity = item.opacity * (fades ? std::min(1.0, 4 * share) : 1);
    mixed += opacity * (255 * colour_of(item.colour_map, share) - mixed);
  }
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::lround(value)); };
  return {byte(mixed[0]), byte(mixed[1]), byte(mixed[2])};
}

}  // namespace simplexseg
