// SPDX-License-Identifier: Apache-2.0
// Volumes and NIfTI files for tests.
#pragma once
#include <zlib.h>

#include <cstdio>
#include <cstring>
#include <random>

#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg::test {

enum class Grid { Plain, Rotated, LeftHanded, Sheared };

inline VolumeGeometry odd_geometry(Grid grid) {
  VolumeGeometry g;
  g.size = {5, 4, 3};
  g.spacing_mm = {0.5, 0.75, 2.5};
  g.origin_mm = {-12.25, 100.5, 33.125};
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-2.1, Eigen::Vector3d::UnitZ()) *
       Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitY()))
          .toRotationMatrix();
  if (grid != Grid::Plain) g.direction = turn;
  if (grid == Grid::LeftHanded) g.direction.col(1) *= -1;
  if (grid == Grid::Sheared) g.direction.col(2) = (g.direction.col(2) + 0.25 * g.direction.col(1)).normalized();
  return g;
}

/// Volume with random finite voxel values, including the smallest and the largest value of the type.
inline Volume odd_volume(VoxelType type, Grid grid = Grid::Rotated) {
  Volume volume(odd_geometry(grid), type);
  visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
    std::mt19937_64 random(17);
    for (T& v : volume.voxels<T>()) {
      do {
        const std::uint64_t bits = random();
        std::memcpy(&v, &bits, sizeof v);
      } while (!std::isfinite(double(v)));
    }
    volume.voxels<T>()[0] = std::numeric_limits<T>::lowest();
    volume.voxels<T>()[1] = std::numeric_limits<T>::max();
  });
  return volume;
}

inline bool same_voxels(const Volume& a, const Volume& b) {
  return a.type() == b.type() && a.bytes() == b.bytes() && std::memcmp(a.data(), b.data(), a.bytes()) == 0;
}

/// Bytes of a valid .nii file: 352 bytes of header, then the voxels.
inline std::string nifti_bytes(const std::filesystem::path& folder, const Volume& volume) {
  write_volume(folder / "made.nii", volume);
  return bytes_of(folder / "made.nii");
}

template <class T>
void patch(std::string& bytes, std::size_t at, T value) {
  std::memcpy(&bytes[at], &value, sizeof value);
}

inline std::filesystem::path write_gzip(const std::filesystem::path& path, const std::string& bytes) {
  gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(file);
  return path;
}

/// Output of a shell command; "" if the command fails.
inline std::string output_of(const std::string& command) {
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return {};
  std::string text;
  char block[4096];
  for (std::size_t n = 0; (n = std::fread(block, 1, sizeof block, pipe)) > 0;) text.append(block, n);
  return ::pclose(pipe) == 0 ? text : "";
}

}  // namespace simplexseg::test
