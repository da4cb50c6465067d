// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "gui/look/slice_geometry.h"
#include "image/plane_samples.h"
#include "session/scene.h"

namespace simplexseg {

class ThreadPool;

/// Layer whose voxels are in memory, with its transform.
struct LayerSource {
  LayerItem item;
  std::shared_ptr<const Volume> image;
  Transform transform;  ///< LayerImages::transform_of()
};

/// Section of a layer as a texture.
struct LayerSlice {
  LayerItem item;
  SliceGrid grid;
  unsigned texture = 0;  ///< red: value times green; green: 1 within the layer (PlaneSample)
};

/// Grid over the same rectangle whose texels are about as fine as `finest_mm`, at most 1024 per side unless `grid` has
/// more.
SliceGrid refined_grid(const SliceGrid& grid, double finest_mm);

/// Textures of the layers in the slices of all views. A texture is written again only when its plane, its image or its
/// transform has changed; window, colours and opacity are applied when it is drawn. Values are computed on the CPU,
/// with every engine, and nothing is read back. All calls need a context of the views to be current.
class LayerSlices {
 public:
  LayerSlices();
  ~LayerSlices();
  /// Sections of the layers in a slice, in the order of `sources`. `slot`: index of the slice among those of the views;
  /// `begin_writing` and `end_writing` are called around changes of textures. The result is valid until the next call.
  const std::vector<LayerSlice>& update(int slot, const SliceGrid& slice, std::span<const LayerSource> sources,
                                        const std::function<void()>& begin_writing,
                                        const std::function<void()>& end_writing);
  /// Deletes all textures.
  void release();

 private:
  struct Texture {
    LayerSlice slice;
    std::shared_ptr<const Volume> image;
    LayerTransform transform;
    int width = 0, height = 0;
  };
  struct Slot {
    std::vector<Texture> textures;
    std::vector<LayerSlice> shown;
  };
  void write(Texture& texture, const LayerSource& source, const SliceGrid& grid);

  std::vector<Slot> slots_;
  std::vector<PlaneSample> samples_;
  std::unique_ptr<ThreadPool> pool_;  ///< created with the first layer
};

}  // namespace simplexseg
