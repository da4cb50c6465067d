// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/volume_texture.h"

#include <GL/glew.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "core/expect.h"
#include "core/thread_pool.h"

namespace simplexseg {

std::size_t VolumeBlocks::count() const {
  return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
}

VolumeBlocks choose_blocks(const VolumeGeometry& geometry, std::size_t most) {
  SIMPLEXSEG_EXPECT(most > 0);
  constexpr int kLongestSide = 2048;  // smallest limit that OpenGL permits
  VolumeBlocks blocks;
  blocks.size = geometry.size;
  const auto enlarge = [&](std::size_t axis) {
    const int voxels = ++blocks.voxels[axis];
    blocks.size[axis] = (geometry.size[axis] + voxels - 1) / voxels;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    while (blocks.size[axis] > kLongestSide) enlarge(axis);
  while (blocks.count() > most) {
    std::size_t shortest = 3;
    double least_mm = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double length_mm = geometry.spacing_mm[static_cast<int>(axis)] * blocks.voxels[axis];
      if (blocks.size[axis] > 1 && (shortest == 3 || length_mm < least_mm)) shortest = axis, least_mm = length_mm;
    }
    enlarge(shortest);
  }
  return blocks;
}

namespace {
/// Adds a row of voxels to the sums or maxima of a row of blocks.
template <class T>
void add_row(std::span<const T> voxels, int voxels_per_block, BlockValue value, double lowest,
             std::vector<double>& blocks) {
  std::size_t block = 0;
  int in_block = 0;
  for (const T voxel : voxels) {
    auto v = static_cast<double>(voxel);
    if constexpr (std::is_floating_point_v<T>) v = std::isfinite(v) ? v : lowest;
    blocks[block] = value == BlockValue::Mean ? blocks[block] + v : std::max(blocks[block], v);
    if (++in_block == voxels_per_block) in_block = 0, ++block;
  }
}
}  // namespace

std::vector<std::uint16_t> block_values(const Volume& volume, const VolumeBlocks& blocks, BlockValue value,
                                        const Volume::Range& range, int k_first, int k_last) {
  const std::array<int, 3>&size = volume.geometry().size, &per_block = blocks.voxels;
  // First voxel of a block, or the end of the volume.
  const auto begin_of = [&](std::size_t axis, int block) { return std::min(block * per_block[axis], size[axis]); };
  const double scale = range.max > range.min ? 65535 / (range.max - range.min) : 0;
  std::vector<std::uint16_t> values;
  std::vector<double> row(static_cast<std::size_t>(blocks.size[0]));
  for (int k = k_first; k < k_last; ++k)
    for (int j = 0; j < blocks.size[1]; ++j) {
      std::fill(row.begin(), row.end(), value == BlockValue::Mean ? 0.0 : range.min);
      visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
        for (int vk = begin_of(2, k); vk < begin_of(2, k + 1); ++vk)
          for (int vj = begin_of(1, j); vj < begin_of(1, j + 1); ++vj)
            add_row(volume.voxels<T>().subspan(volume.offset(0, vj, vk), static_cast<std::size_t>(size[0])),
                    per_block[0], value, range.min, row);
      });
      const int rows = (begin_of(1, j + 1) - begin_of(1, j)) * (begin_of(2, k + 1) - begin_of(2, k));
      for (int i = 0; i < blocks.size[0]; ++i) {
        const int count = value == BlockValue::Mean ? rows * (begin_of(0, i + 1) - begin_of(0, i)) : 1;
        const double v = row[static_cast<std::size_t>(i)] / count;
        values.push_back(static_cast<std::uint16_t>(std::clamp((v - range.min) * scale + 0.5, 0.0, 65535.0)));
      }
    }
  return values;
}

void VolumeTexture::update(const Volume& volume, BlockValue value, std::size_t most_texels) {
  SIMPLEXSEG_EXPECT(!volume.empty());
  const VolumeBlocks blocks = choose_blocks(volume.geometry(), most_texels);
  const bool same_values = value == value_ || blocks.voxels == std::array{1, 1, 1};
  if (name_ && volume_.data() == volume.data() && same_values) return;
  release();
  volume_ = volume;
  value_ = value;
  blocks_ = blocks;
  range_ = volume.range();
  glCreateTextures(GL_TEXTURE_3D, 1, &name_);
  glTextureStorage3D(name_, 1, GL_R16, blocks.size[0], blocks.size[1], blocks.size[2]);
  glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(name_, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    glTextureParameteri(name_, axis, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  // A few layers at once: the texture needs no copy of the whole volume in the memory of the host.
  ThreadPool pool(std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  std::vector<std::vector<std::uint16_t>> layers(static_cast<std::size_t>(2 * pool.threads()));
  for (int first = 0; first < blocks.size[2]; first += static_cast<int>(layers.size())) {
    const int count = std::min(static_cast<int>(layers.size()), blocks.size[2] - first);
    pool.run(count, [&](int n) {
      layers[static_cast<std::size_t>(n)] = block_values(volume, blocks, value, range_, first + n, first + n + 1);
    });
    for (int n = 0; n < count; ++n)
      glTextureSubImage3D(name_, 0, 0, 0, first + n, blocks.size[0], blocks.size[1], 1, GL_RED, GL_UNSIGNED_SHORT,
                          layers[static_cast<std::size_t>(n)].data());
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

void VolumeTexture::release() {
  glDeleteTextures(1, &name_);
  name_ = 0;
  volume_ = {};
  blocks_ = {};
}

Eigen::Vector3d VolumeTexture::extent() const {
  Eigen::Vector3d extent;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    extent[axis] = static_cast<double>(volume_.geometry().size[a]) / (blocks_.voxels[a] * blocks_.size[a]);
  }
  return extent;
}

Eigen::Matrix4d VolumeTexture::texture_from_world() const {
  Eigen::Affine3d transform = Eigen::Translation3d(0.5, 0.5, 0.5) * volume_.geometry().index_from_world();
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    transform.matrix().row(axis) /= static_cast<double>(blocks_.voxels[a]) * blocks_.size[a];
  }
  return transform.matrix();
}

double VolumeTexture::texel_value(double intensity) const {
  return range_.max > range_.min ? (intensity - range_.min) / (range_.max - range_.min) : 0;
}

}  // namespace simplexseg
