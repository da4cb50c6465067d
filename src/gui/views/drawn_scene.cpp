// SPDX-License-Identifier: Apache-2.0
#include "gui/views/drawn_scene.h"

#include "core/expect.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

DrawnScene::DrawnScene(Workbench& workbench) : workbench_(workbench) {
  for (const auto signal : {&Workbench::volume_changed, &Workbench::volume_filtered})
    connect(&workbench_, signal, this, &DrawnScene::begin_volume);
}

void DrawnScene::begin_volume() {
  buffers_.invalidate_slices();
  failed_ = false;
}

const SceneBuffers* DrawnScene::surfaces() {
  const bool drawn = update_buffers([this](Session& session) { buffers_.update_surfaces(session, workbench_.view); });
  return drawn ? &buffers_ : nullptr;
}

bool DrawnScene::surface_values() {
  bool coloured = false;
  return update_buffers(
             [&](Session& session) { coloured = buffers_.update_values(session, workbench_.view.surface_values); }) &&
         coloured;
}

const SceneBuffers::Outlines* DrawnScene::outlines(Orientation orientation, int neighbour) {
  SIMPLEXSEG_EXPECT(workbench_.has_volume());
  const SceneBuffers::Outlines* outlines = nullptr;
  const bool drawn = update_buffers([&](Session& session) {
    outlines = &buffers_.update_outlines(session, workbench_.view, orientation, neighbour);
  });
  return drawn ? outlines : nullptr;
}

const PointSprings& DrawnScene::springs() {
  update_buffers([this](Session& session) { springs_.update(session, workbench_.running()); });
  return springs_;
}

const SceneBuffers::Slice* DrawnScene::slice(Orientation orientation, int neighbour) {
  SIMPLEXSEG_EXPECT(workbench_.has_volume());
  const SceneBuffers::Slice* slice = nullptr;
  const bool drawn = update_buffers(
      [&](Session& session) { slice = &buffers_.update_slice(session, workbench_.view, orientation, neighbour); });
  return drawn ? slice : nullptr;
}

const SceneBuffers::Slice* DrawnScene::free_slice(const std::optional<SliceGrid>& grid) {
  SIMPLEXSEG_EXPECT(workbench_.has_volume());
  if (!grid) {
    buffers_.release_free_slice();
    return nullptr;
  }
  const SceneBuffers::Slice* slice = nullptr;
  const bool drawn =
      update_buffers([&](Session& session) { slice = &buffers_.update_free_slice(session, workbench_.view, *grid); });
  return drawn ? slice : nullptr;
}

const std::vector<LayerSlice>* DrawnScene::layers(const SliceGrid& grid, Orientation orientation, int neighbour) {
  const LayerImages& images = workbench_.layer_images();
  std::vector<LayerSource> sources;
  for (const LayerItem& item : workbench_.scene().layers) {
    std::shared_ptr<const Volume> image = images.image_of(item);
    if (item.visible && image && images.has_transform(item))
      sources.push_back({item, std::move(image), images.transform_of(item)});
  }
  const std::vector<LayerSlice>* layers = nullptr;
  const bool drawn =
      update_buffers([&](Session&) { layers = &buffers_.update_layers(grid, sources, orientation, neighbour); });
  return drawn ? layers : nullptr;
}

const SceneBuffers::Field* DrawnScene::field() {
  const SceneBuffers::Field* field = nullptr;
  const bool drawn = update_buffers([&](Session& session) { field = buffers_.update_field(session, workbench_.view); });
  return drawn ? field : nullptr;
}

bool DrawnScene::update_buffers(const std::function<void(Session&)>& update) {
  if (failed_) return false;
  const std::string before = buffers_.transfer_mode();
  failed_ = !workbench_.draw(update);
  // Queued: no signal that changes the window may be emitted while a view paints.
  if (buffers_.transfer_mode() != before)
    QMetaObject::invokeMethod(this, &DrawnScene::transfer_mode_changed, Qt::QueuedConnection);
  return !failed_;
}

}  // namespace simplexseg
