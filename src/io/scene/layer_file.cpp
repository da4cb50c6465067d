// SPDX-License-Identifier: Apache-2.0
#include "io/scene/layer_file.h"

#include <utility>

#include "image/contrast_range.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"

namespace simplexseg {

LayerFile read_layer(const std::filesystem::path& path) {
  LoadedVolume loaded = load_volume(path);
  LayerFile layer;
  LayerItem& item = layer.item;
  item.path = std::filesystem::absolute(path).lexically_normal().string();
  item.checksum = checksum_of(loaded.volume);
  item.unit = loaded.intensity_unit;
  const Volume::Range range = contrast_range(loaded.volume);
  item.window = range.max - range.min;
  item.level = (range.max + range.min) / 2;
  item.name = loaded.series;
  if (item.name.empty()) {
    const std::filesystem::path place(item.path);
    const std::string file = (place.has_filename() ? place : place.parent_path()).filename().string();
    item.name = file.substr(0, file.find('.', 1));
  }
  if (loaded.uptake.factor > 0) {
    item.scale = loaded.uptake.factor;
    item.unit = "SUV";
    item.colour_map = ColourMap::Hot;
    constexpr double kUsualWindow = 10;  // of FDG
    item.window = kUsualWindow, item.level = kUsualWindow / 2;
  } else if (std::string why = uptake_warning(path, loaded.uptake); !why.empty()) {
    loaded.warnings.push_back(std::move(why));
  }
  layer.warnings = std::move(loaded.warnings);
  layer.image = std::make_shared<const Volume>(std::move(loaded.volume));
  return layer;
}

}  // namespace simplexseg
