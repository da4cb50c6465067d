// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "image/volume.h"
#include "session/layer.h"

namespace simplexseg {

/// New layer for an image, with its voxels.
struct LayerFile {
  LayerItem item;
  std::shared_ptr<const Volume> image;
  std::vector<std::string> warnings;  ///< one line each, for the user
};

/// Reads an image or DICOM folder as a layer. Its name is that of the series or the file, its window contrast_range();
/// PET in DICOM has uptake values, or a warning with the reason why not. Throws the errors of load_volume().
LayerFile read_layer(const std::filesystem::path& path);

}  // namespace simplexseg
