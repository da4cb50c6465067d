// SPDX-License-Identifier: Apache-2.0
// Images in which the field of a mesh is solved: the volume of the scene or layers.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "image/volume.h"
#include "session/layer.h"

namespace simplexseg {

struct Scene;

/// Images of the field of a mesh, by the ids of layers; 0: the volume of the scene.
struct MeshImages {
  std::uint32_t main = 0;              ///< in which the field finds edges and surface
  std::vector<std::uint32_t> further;  ///< which inform its prior in addition

  bool is_default() const { return main == 0 && further.empty(); }
  bool uses(std::uint32_t image) const;
  bool operator==(const MeshImages&) const = default;
};

inline constexpr std::size_t kMostFurtherImages = 7;

/// Image of a layer on the grid of the volume: 32-bit floating-point numbers, NaN outside the layer. Throws Error if
/// its files cannot be read.
using LayerOnGrid = std::function<Volume(const LayerItem& layer, const VolumeGeometry& grid)>;

/// Throws Error unless each image is the volume or a layer of the scene, and no two are equal. `name`: of the mesh.
void check_images(const Scene& scene, const MeshImages& images, const std::string& name);

/// Layers of the images of a field; nullopt: the volume of the scene.
struct LayersOfField {
  std::optional<LayerItem> main;
  std::vector<std::optional<LayerItem>> further;
};
LayersOfField layers_of(const Scene& scene, const MeshImages& images);

/// Digest of the files and transforms of images, which changes with their contents; 0 for the volume alone.
std::uint64_t digest_of(const Scene& scene, const MeshImages& images);
/// Digest of the file and the transform of a layer; 0 for the volume.
std::uint64_t digest_of(const std::optional<LayerItem>& layer);

}  // namespace simplexseg
