// SPDX-License-Identifier: Apache-2.0
// Layers: further images of a scene, shown over its volume. A scene has their files and display; their voxels belong to
// LayerImages (io/scene/layer_images.h).
#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "image/preprocessing.h"

namespace simplexseg {

enum class ColourMap : std::uint8_t { Grey, InvertedGrey, Hot, Green, Magenta };

/// Names of a colour map.
struct ColourMapInfo {
  ColourMap map;
  const char* name;   ///< in files
  const char* title;  ///< for users
};
/// All colour maps, in the order of ColourMap.
std::span<const ColourMapInfo> colour_maps();
const ColourMapInfo& info_of(ColourMap map);
/// Colour map with a name; nullopt for an unknown name.
std::optional<ColourMap> find_colour_map(const std::string& name);

/// Transform from points of the scene's volume to points of a layer, mm in LPS: that of the file, then the matrix.
struct LayerTransform {
  std::string file;      ///< path of a file with a displacement field, as in the scene file; "": none
  std::string checksum;  ///< of the bytes of the file
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();

  bool is_identity() const { return file.empty() && affine.matrix().isIdentity(0); }
  bool operator==(const LayerTransform& other) const {
    return file == other.file && checksum == other.checksum && affine.matrix() == other.affine.matrix();
  }
};

/// Image that is shown over the volume of a scene.
struct LayerItem {
  std::uint32_t id = 0;
  std::string name;
  std::string path;      ///< path of the image, as in the scene file
  int number = 1;        ///< number of the volume in a 4D file, from 1
  std::string series;    ///< UID of the series in a DICOM folder; empty: the largest series
  std::string checksum;  ///< checksum of the image (io/volume/volume_checksum.h); "": unknown
  double scale = 1;      ///< factor from stored values to shown values, such as standardized uptake values of PET
  std::string unit;      ///< unit of shown values, such as "HU" or "SUV"; "": unknown
  Preprocessing preprocessing{};  ///< filters of the image, whose file stays as it is
  LayerTransform transform;
  ColourMap colour_map = ColourMap::Grey;
  float opacity = 0.5f;          ///< opacity of a blend, 0 to 1
  double window = 1, level = 0;  ///< shown values level -+ window/2 have the first and the last colour
  bool visible = true;
  bool operator==(const LayerItem&) const = default;
};

/// Throws Error unless names and path are not empty, and all numbers finite and in range: scale and window above 0,
/// opacity from 0 to 1, an invertible affine map.
void check_layer(const LayerItem& layer);

}  // namespace simplexseg
