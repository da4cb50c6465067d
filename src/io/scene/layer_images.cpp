// SPDX-License-Identifier: Apache-2.0
#include "io/scene/layer_images.h"

#include <zlib.h>

#include <limits>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/data_path.h"
#include "io/platform/files.h"
#include "io/registration/filters.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

constexpr const char* kOtherResult =
    "its filters give other values than those with which the scene was saved, because the image or the version of ITK "
    "differs: check that the segmentations are right";

std::string checksum_of_file(const fs::path& path) {
  const std::string bytes = read_bytes(path);
  const uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  return "crc32-" + hexadecimal_text(crc, 8) + "-" + std::to_string(bytes.size());
}

}  // namespace

std::shared_ptr<const Volume> LayerImages::image_of(const LayerItem& layer) const {
  const auto found = images_.find(key_of_image(layer));
  return found == images_.end() ? nullptr : found->second;
}

bool LayerImages::has_transform(const LayerItem& layer) const {
  return layer.transform.file.empty() || transforms_.contains({layer.transform.file, layer.transform.checksum});
}

Transform LayerImages::transform_of(const LayerItem& layer) const {
  Transform all;
  const auto found = transforms_.find({layer.transform.file, layer.transform.checksum});
  if (!layer.transform.file.empty() && found != transforms_.end()) all = found->second;
  if (!layer.transform.affine.matrix().isIdentity(0)) all.append(layer.transform.affine);
  return all;
}

std::optional<double> LayerImages::value_at(const LayerItem& layer, const Eigen::Vector3d& world_mm) const {
  const std::shared_ptr<const Volume> image = image_of(layer);
  if (!image || !has_transform(layer)) return std::nullopt;
  const Eigen::Vector3d at = transform_of(layer)(world_mm);
  if (!at.allFinite() || !image->geometry().contains(at)) return std::nullopt;
  return layer.scale * image->sample(at);
}

Volume LayerImages::on_grid(const LayerItem& layer, const VolumeGeometry& grid) const {
  const std::shared_ptr<const Volume> image = image_of(layer);
  if (!image || !has_transform(layer))
    throw Error("layer '" + layer.name + "'", "its image or its transform is not loaded",
                "bring its file back and open the scene again, or choose other images of the segmentation");
  return resample_through(*image, grid, transform_of(layer), 0, std::numeric_limits<float>::quiet_NaN());
}

LayerOnGrid layer_file_source(const fs::path& scene_folder) {
  return [scene_folder](const LayerItem& layer, const VolumeGeometry& grid) {
    LayerImages images;
    Scene scene;
    scene.layers.push_back(layer);
    std::vector<std::string> warnings;
    images.load(scene, scene_folder, warnings);
    if (!images.image_of(layer) || !images.has_transform(layer))
      throw Error("layer '" + layer.name + "'", warnings.empty() ? "its image is not loaded" : warnings.front(),
                  "bring its file back, or choose other images of the segmentation");
    return images.on_grid(layer, grid);
  };
}

void LayerImages::add_image(const LayerItem& layer, std::shared_ptr<const Volume> image) {
  images_.insert_or_assign(key_of_image(layer), std::move(image));
}

std::string LayerImages::add_filtered(const LayerItem& layer) {
  LayerItem part = layer;
  const auto choose = [&](std::span<const FilterStep> filters) {
    part.preprocessing.filters.assign(filters.begin(), filters.end());
  };
  const auto find = [&](std::span<const FilterStep> filters) {
    choose(filters);
    const Volume* const image = image_of(part).get();
    if (!image && filters.empty()) throw Error(quoted(layer.path), "it is not loaded", "open the scene again");
    return image;
  };
  const auto add = [&](std::span<const FilterStep> filters, Volume result) {
    choose(filters);
    add_image(part, std::make_shared<const Volume>(std::move(result)));
  };
  return checksum_of(
      apply_filters(layer.preprocessing.filters, find, add,
                    [](const Volume& image, const FilterStep& step) { return filter_volume(image, step); }));
}

void LayerImages::add_transform(const LayerTransform& transform, Transform loaded) {
  transforms_.insert_or_assign({transform.file, transform.checksum}, std::move(loaded));
}

void LayerImages::add(const LayerImages& others) {
  for (const auto& [key, image] : others.images_) images_.insert_or_assign(key, image);
  for (const auto& [key, transform] : others.transforms_) transforms_.insert_or_assign(key, transform);
}

void LayerImages::load(const Scene& scene, const fs::path& scene_folder, std::vector<std::string>& warnings) {
  for (const LayerItem& layer : scene.layers) {
    const std::string what = "layer '" + layer.name + "' is not shown: ";
    try {
      LayerItem source = layer;
      source.preprocessing = {};
      if (!image_of(source)) {
        const fs::path path = find_data(layer.path, scene_folder);
        LoadedVolume loaded = load_volume(path, layer.number, layer.series);
        if (!layer.checksum.empty() && checksum_of(loaded.volume) != layer.checksum)
          warnings.push_back("layer '" + layer.name + "': " + quoted(path) +
                             " is not the image with which the scene was saved: check that it is in the right place");
        add_image(source, std::make_shared<const Volume>(std::move(loaded.volume)));
      }
      if (!image_of(layer)) {
        const std::string& expected = layer.preprocessing.checksum;
        if (const std::string checksum = add_filtered(layer); !expected.empty() && checksum != expected)
          warnings.push_back("layer '" + layer.name + "': " + kOtherResult);
      }
      if (has_transform(layer)) continue;
      const fs::path file = find_data(layer.transform.file, scene_folder);
      if (!layer.transform.checksum.empty() && checksum_of_file(file) != layer.transform.checksum)
        throw Error(quoted(file), "it is not the transform with which the scene was saved",
                    "restore the earlier file, or register the layer again");
      add_transform(layer.transform, read_transform(file));
    } catch (const Error& error) {
      warnings.push_back(what + error.what());
    }
  }
}

LayerTransform load_layer_transform(const fs::path& path, Transform& loaded) {
  loaded = read_transform(path);
  LayerTransform transform;
  if (const std::optional<Eigen::Affine3d> affine = loaded.affine()) {
    transform.affine = *affine;
    return transform;
  }
  transform.file = fs::absolute(path).lexically_normal().string();
  transform.checksum = checksum_of_file(path);
  return transform;
}

}  // namespace simplexseg
