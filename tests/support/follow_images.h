// SPDX-License-Identifier: Apache-2.0
// Images of a lesion in several studies or time points.
#pragma once
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/volume/volume_io.h"

namespace simplexseg {

inline const Eigen::Vector3d kLesionCentre(40, 38, 42);
inline constexpr double kLesionRadius = 14;

/// Bright ball, the lesion, over a background with two dimmer ones, all moved by `shift`, mm.
inline Volume lesion_image(const Eigen::Vector3d& shift, double radius) {
  Volume volume(VolumeGeometry{.size = {42, 42, 42}, .spacing_mm = {2, 2, 2}}, VoxelType::Int16);
  for (int k = 0; k < 42; ++k)
    for (int j = 0; j < 42; ++j)
      for (int i = 0; i < 42; ++i) {
        const Eigen::Vector3d at = Eigen::Vector3d(2 * i, 2 * j, 2 * k) - shift;
        const auto ball = [&](const Eigen::Vector3d& centre, double r) {
          return 1 / (1 + std::exp(2 * ((at - centre).norm() - r)));
        };
        const double value =
            400 * ball(kLesionCentre, radius) + 150 * ball({64, 60, 60}, 9) + 200 * ball({20, 62, 24}, 7);
        volume.voxels<std::int16_t>()[volume.offset(i, j, k)] =
            static_cast<std::int16_t>(value + (7 * i + 13 * j + 29 * k) % 17);
      }
  return volume;
}

/// Writes images of one grid as a 4D file (.nii) with an interval in ms.
inline void write_series(const std::filesystem::path& path, const std::vector<Volume>& volumes, float interval_ms) {
  write_volume(path, volumes.front());
  std::ifstream in(path, std::ios::binary);
  std::string file((std::istreambuf_iterator<char>(in)), {});
  in.close();
  file.resize(file.size() - volumes.front().bytes());
  const auto put = [&](std::size_t at, auto value) { std::memcpy(file.data() + at, &value, sizeof value); };
  put(40, std::int16_t{4}), put(48, static_cast<std::int16_t>(volumes.size())), put(92, interval_ms);
  file[123] = 2 + 16;  // mm and ms
  for (const Volume& volume : volumes) file.append(static_cast<const char*>(volume.data()), volume.bytes());
  std::ofstream(path, std::ios::binary) << file;
}

}  // namespace simplexseg
