// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

/// Value of a texel that stands for a block of voxels.
enum class BlockValue { Mean, Maximum };

/// Blocks of voxels of a volume, each with one value of 16 bits: 0 and 65535 stand for the range of the volume.
struct VolumeBlocks {
  std::array<int, 3> voxels{1, 1, 1};  ///< voxels per block along i, j, k
  std::array<int, 3> size{0, 0, 0};    ///< number of blocks; the last one along an axis can have fewer voxels
  std::size_t count() const;
};
/// Smallest blocks of which at most `most`, and at most 2048 along each axis, cover the volume; as cubic as the spacing
/// permits.
VolumeBlocks choose_blocks(const VolumeGeometry& geometry, std::size_t most);
/// Values of the blocks k_first ... k_last - 1 along k, i fastest. Voxels that are not finite count as range.min.
std::vector<std::uint16_t> block_values(const Volume& volume, const VolumeBlocks& blocks, BlockValue value,
                                        const Volume::Range& range, int k_first, int k_last);

/// 3D texture of a volume, reduced to blocks of voxels if the volume has more voxels than the texture may have texels.
class VolumeTexture {
 public:
  /// Uploads the volume if it or the kind of values has changed. Needs a volume that is not empty.
  void update(const Volume& volume, BlockValue value, std::size_t most_texels);
  void release();
  /// Memory of the texture; 0 after release().
  std::size_t bytes() const { return name_ ? 2 * blocks_.count() : 0; }

  unsigned name() const { return name_; }
  const std::array<int, 3>& size() const { return blocks_.size; }
  /// Texture coordinates of a position in mm.
  Eigen::Matrix4d texture_from_world() const;
  /// Texture coordinates of the outer corner of the last voxel; the first one has its outer corner at 0.
  Eigen::Vector3d extent() const;
  /// Value of a texel (0..1) for an intensity.
  double texel_value(double intensity) const;

 private:
  unsigned name_ = 0;
  Volume volume_;  ///< volume in the texture
  BlockValue value_ = BlockValue::Mean;
  VolumeBlocks blocks_;
  Volume::Range range_{0, 0};
};

}  // namespace simplexseg
