// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/layer_slices.h"

#include <GL/glew.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "core/thread_pool.h"

namespace simplexseg {

SliceGrid refined_grid(const SliceGrid& grid, double finest_mm) {
  constexpr int kMostTexels = 1024;
  const double texel_mm = std::min(grid.step_u_mm.norm(), grid.step_v_mm.norm());
  const int most = kMostTexels / std::max({grid.width, grid.height, 1});
  const int factor =
      std::clamp(static_cast<int>(std::lround(std::min(texel_mm / finest_mm, 1e6))), 1, std::max(most, 1));
  SliceGrid fine = grid;
  fine.step_u_mm /= factor, fine.step_v_mm /= factor;
  fine.width *= factor, fine.height *= factor;
  fine.origin_mm = grid.corner_mm() + 0.5 * (fine.step_u_mm + fine.step_v_mm);
  return fine;
}

LayerSlices::LayerSlices() = default;
LayerSlices::~LayerSlices() = default;

void LayerSlices::release() {
  for (Slot& slot : slots_)
    for (Texture& texture : slot.textures) glDeleteTextures(1, &texture.slice.texture);
  slots_.clear();
}

const std::vector<LayerSlice>& LayerSlices::update(int slot, const SliceGrid& slice,
                                                   std::span<const LayerSource> sources,
                                                   const std::function<void()>& begin_writing,
                                                   const std::function<void()>& end_writing) {
  if (slots_.size() <= static_cast<std::size_t>(slot)) slots_.resize(static_cast<std::size_t>(slot) + 1);
  auto& [textures, shown] = slots_[static_cast<std::size_t>(slot)];
  bool writes = false;
  const auto begin = [&] {
    if (!writes) begin_writing();
    writes = true;
  };
  const auto is_used = [&](const Texture& texture) {
    return std::any_of(sources.begin(), sources.end(),
                       [&](const LayerSource& source) { return source.item.id == texture.slice.item.id; });
  };
  for (Texture& texture : textures)
    if (!is_used(texture)) {
      begin();
      glDeleteTextures(1, &texture.slice.texture);
      texture.slice.texture = 0;
    }
  std::erase_if(textures, [&](const Texture& texture) { return !is_used(texture); });
  shown.clear();
  for (const LayerSource& source : sources) {
    auto found = std::find_if(textures.begin(), textures.end(),
                              [&](const Texture& texture) { return texture.slice.item.id == source.item.id; });
    if (found == textures.end()) found = textures.insert(textures.end(), Texture{});
    const SliceGrid grid = refined_grid(slice, source.image->geometry().spacing_mm.minCoeff());
    if (found->image != source.image || !(found->slice.grid == grid) || !(found->transform == source.item.transform)) {
      begin();
      write(*found, source, grid);
    }
    found->slice.item = source.item;
    shown.push_back(found->slice);
  }
  if (writes) end_writing();
  return shown;
}

void LayerSlices::write(Texture& texture, const LayerSource& source, const SliceGrid& grid) {
  if (!pool_) pool_ = std::make_unique<ThreadPool>(std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  samples_.resize(static_cast<std::size_t>(grid.width) * grid.height);
  sample_plane(*source.image, source.transform,
               {grid.origin_mm, grid.step_u_mm, grid.step_v_mm, grid.width, grid.height}, samples_, *pool_);
  if (texture.slice.texture == 0 || texture.width != grid.width || texture.height != grid.height) {
    glDeleteTextures(1, &texture.slice.texture);
    glCreateTextures(GL_TEXTURE_2D, 1, &texture.slice.texture);
    glTextureStorage2D(texture.slice.texture, 1, GL_RG32F, grid.width, grid.height);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTextureParameteri(texture.slice.texture, filter, GL_LINEAR);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
      glTextureParameteri(texture.slice.texture, axis, GL_CLAMP_TO_EDGE);
    texture.width = grid.width, texture.height = grid.height;
  }
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTextureSubImage2D(texture.slice.texture, 0, 0, 0, grid.width, grid.height, GL_RG, GL_FLOAT, samples_.data());
  texture.image = source.image;
  texture.transform = source.item.transform;
  texture.slice.grid = grid;
}

}  // namespace simplexseg
