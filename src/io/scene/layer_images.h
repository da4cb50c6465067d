// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "image/transform.h"
#include "image/volume.h"
#include "session/scene.h"

namespace simplexseg {

/// Voxels and displacement fields of layers, which a scene refers to by their files. Copies share them.
class LayerImages {
 public:
  /// Image of a layer; null if it is not loaded.
  std::shared_ptr<const Volume> image_of(const LayerItem& layer) const;
  /// Whether the file of a layer's transform is loaded, or it has none.
  bool has_transform(const LayerItem& layer) const;
  /// Transform from points of the scene's volume to points of the layer; that of the matrix alone if the file is not
  /// loaded.
  Transform transform_of(const LayerItem& layer) const;
  /// Value that a layer shows at a point of the scene's volume, interpolated; nullopt outside the layer, or if its
  /// files are not loaded.
  std::optional<double> value_at(const LayerItem& layer, const Eigen::Vector3d& world_mm) const;

  /// Image of a layer on a grid (LayerOnGrid). Throws Error if its files are not loaded.
  Volume on_grid(const LayerItem& layer, const VolumeGeometry& grid) const;

  void add_image(const LayerItem& layer, std::shared_ptr<const Volume> image);
  /// Applies the filters of a layer to its image, which must have been added without filters; those that are applied
  /// already are not applied again. Returns the checksum of the result. Throws the errors of filter_volume(), and
  /// Cancelled (LoadProgress).
  std::string add_filtered(const LayerItem& layer);
  void add_transform(const LayerTransform& transform, Transform loaded);
  void add(const LayerImages& others);
  /// Reads the files of the layers of a scene that are not loaded yet; find_data() searches for images. A file that is
  /// missing, cannot be read or has changed adds a warning of one line. Throws Cancelled (LoadProgress).
  void load(const Scene& scene, const std::filesystem::path& scene_folder, std::vector<std::string>& warnings);

 private:
  using Key = std::tuple<std::string, int, std::string, std::string>;  ///< path, number, series and filters
  static Key key_of_image(const LayerItem& layer) {
    return {layer.path, layer.number, layer.series, key_of(layer.preprocessing.filters)};
  }
  std::map<Key, std::shared_ptr<const Volume>> images_;
  std::map<std::pair<std::string, std::string>, Transform> transforms_;  ///< key: path and checksum
};

/// Source of the images of layers that reads their files when they are requested, as LayerImages::load().
LayerOnGrid layer_file_source(const std::filesystem::path& scene_folder);

/// Reads a transform for a layer: an affine map becomes the matrix; a file with a displacement field is referred to by
/// its absolute path, and its transform is stored in `loaded`. Throws the errors of read_transform().
LayerTransform load_layer_transform(const std::filesystem::path& path, Transform& loaded);

}  // namespace simplexseg
