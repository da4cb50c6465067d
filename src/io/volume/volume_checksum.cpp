// SPDX-License-Identifier: Apache-2.0
#include "io/volume/volume_checksum.h"

#include <zlib.h>

#include "core/number_text.h"
#include "image/volume.h"

namespace simplexseg {
namespace {

uLong add(uLong checksum, const void* data, std::size_t bytes) {
  return crc32_z(checksum, static_cast<const Bytef*>(data), bytes);
}

}  // namespace

std::string checksum_of(const Volume& volume) {
  if (volume.empty()) return {};
  const VolumeGeometry& grid = volume.geometry();
  const VoxelType type = volume.type();
  uLong checksum = crc32_z(0, nullptr, 0);
  checksum = add(checksum, grid.size.data(), sizeof grid.size);
  checksum = add(checksum, grid.spacing_mm.data(), 3 * sizeof(double));
  checksum = add(checksum, grid.origin_mm.data(), 3 * sizeof(double));
  checksum = add(checksum, grid.direction.data(), 9 * sizeof(double));
  checksum = add(checksum, &type, sizeof type);
  checksum = add(checksum, volume.data(), volume.bytes());
  return "crc32-" + hexadecimal_text(checksum, 8) + "-" + std::to_string(volume.bytes());
}

}  // namespace simplexseg
