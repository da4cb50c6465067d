// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/scene_buffers.h"

#include <GL/glew.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/expect.h"
#include "gui/drawing/painters.h"
#include "gui/look/surface_values.h"
#include "gui/look/view_state.h"
#include "session/session.h"

namespace simplexseg {

void SceneBuffers::attach(const void* view) {
  views_.try_emplace(view, nullptr);
  renderer_ = gl_renderer();
}

void SceneBuffers::detach(const void* view) {
  const auto found = views_.find(view);
  if (found == views_.end()) return;
  glDeleteSync(found->second);
  views_.erase(found);
  if (views_.empty()) release_all();
}

void SceneBuffers::release_all() {
  release(points_);
  glDeleteBuffers(1, &indices_);
  indices_ = 0;
  for (SliceState& state : slices_) release(state);
  release(free_slice_);
  layers_.release();
  for (OutlineState& state : outlines_) {
    release(state.buffer);
    state = {};
  }
  release_field();
  glDeleteBuffers(1, &values_);
  values_ = 0;
  shown_values_.reset();
  glDeleteSync(written_);
  written_ = nullptr;
  triangles_.clear();
  revision_ = topology_ = ~std::uint64_t{0};
}

// A context sees the writes of another context once they are complete; fences order them on the GPU.
void SceneBuffers::begin_reading() const {
  if (written_) glWaitSync(written_, 0, GL_TIMEOUT_IGNORED);
}

void SceneBuffers::end_reading(const void* view) {
  const auto found = views_.find(view);
  if (found == views_.end()) return;
  glDeleteSync(found->second);
  found->second = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();  // a fence that has not been submitted is never signalled
}

void SceneBuffers::wait_for_readers() {
  for (auto& [view, fence] : views_) {
    if (fence) glWaitSync(fence, 0, GL_TIMEOUT_IGNORED);
  }
}

void SceneBuffers::mark_written() {
  glDeleteSync(written_);
  written_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();
}

void SceneBuffers::release(Buffer& buffer) {
  buffer.shared.reset();
  glDeleteBuffers(1, &buffer.name);
  buffer = {};
}

void SceneBuffers::release(SliceState& state) {
  release(state.pixels);
  glDeleteTextures(1, &state.slice.texture);
  state = {};
}

void SceneBuffers::allocate(Buffer& buffer, std::size_t bytes) {
  if (buffer.bytes == bytes) return;
  release(buffer);
  if (bytes == 0) return;
  glCreateBuffers(1, &buffer.name);
  glNamedBufferStorage(buffer.name, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  buffer.bytes = bytes;
}

void SceneBuffers::connect(Buffer& buffer, Session& session) {
  if (buffer.generation == session.engine_generation()) return;
  buffer.shared.reset();
  buffer.shared = session.drawing().share_buffer(buffer.name, buffer.bytes);
  buffer.generation = session.engine_generation();
  on_device_ = buffer.shared != nullptr;
  if (on_device_) {
    transfer_mode_ = "drawn on the device (CUDA writes into OpenGL)";
  } else if (std::strcmp(session.engine().backend(), "cpu") == 0) {
    transfer_mode_ = "uploaded each frame: computed on the CPU";
  } else {
    transfer_mode_ = "uploaded each frame: CUDA cannot write into this OpenGL";
  }
}

void SceneBuffers::rebuild_topology(Session& session) {
  const std::vector<MeshItem>& meshes = session.scene_without_poses().meshes;
  std::vector<CellList>& cells = cells_;
  cells.clear();
  std::vector<const CellList*> lists;
  std::size_t vertex_count = 0;
  for (const MeshItem& item : meshes) {
    cells.push_back(cells_of(item.mesh));
    vertex_count += item.mesh.neighbours.size();
  }
  std::vector<GLuint> indices;
  indices.reserve(9 * vertex_count);
  triangles_.clear();
  std::size_t vertex = 0, centre = vertex_count;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    lists.push_back(&cells[m]);
    Range range{indices.size(), 0};
    for (int c = 0; c < cells[m].count(); ++c, ++centre) {
      const std::span<const int> corners = cells[m][c];
      for (std::size_t k = 0; k < corners.size(); ++k) {
        indices.push_back(static_cast<GLuint>(centre));
        indices.push_back(static_cast<GLuint>(vertex + corners[k]));
        indices.push_back(static_cast<GLuint>(vertex + corners[(k + 1) % corners.size()]));
      }
    }
    range.count = static_cast<int>(indices.size() - range.first);
    triangles_.push_back(range);
    vertex += meshes[m].mesh.neighbours.size();
  }
  session.drawing().set_cells(lists);
  point_count_ = centre;
  vertex_count_ = vertex_count;
  if (indices_ == 0) glCreateBuffers(1, &indices_);
  glNamedBufferData(indices_, static_cast<GLsizeiptr>(indices.size() * sizeof(GLuint)), indices.data(), GL_STATIC_DRAW);
  allocate(points_, point_count_ * sizeof(DisplayPoint));
  topology_ = session.topology_revision();
}

bool SceneBuffers::update_values(const Session& session, const std::shared_ptr<const SurfaceValues>& values) {
  if (!values || topology_ != session.topology_revision() || point_count_ == 0) return false;
  if (shown_values_ == values && values_topology_ == topology_) return true;
  wait_for_readers();
  std::vector<float> all;
  all.reserve(point_count_);
  const std::vector<MeshItem>& meshes = session.scene_without_poses().meshes;
  std::vector<const std::vector<float>*> known;
  for (const MeshItem& item : meshes) {
    const auto found = values->of_mesh.find(item.id);
    const bool fits = found != values->of_mesh.end() && found->second.size() == item.mesh.neighbours.size();
    known.push_back(fits ? &found->second : nullptr);
    if (fits)
      all.insert(all.end(), found->second.begin(), found->second.end());
    else
      all.insert(all.end(), item.mesh.neighbours.size(), -1.0f);
  }
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (int c = 0; c < cells_[m].count(); ++c) {
      const std::span<const int> corners = cells_[m][c];
      float sum = 0;
      for (const int corner : corners) sum += known[m] ? (*known[m])[static_cast<std::size_t>(corner)] : -1.0f;
      all.push_back(sum / static_cast<float>(corners.size()));
    }
  if (values_ == 0) glCreateBuffers(1, &values_);
  glNamedBufferData(values_, static_cast<GLsizeiptr>(all.size() * sizeof(float)), all.data(), GL_STATIC_DRAW);
  mark_written();
  shown_values_ = values;
  values_topology_ = topology_;
  return true;
}

const SceneBuffers::Range& SceneBuffers::triangles(int mesh) const {
  SIMPLEXSEG_EXPECT(mesh >= 0 && mesh < static_cast<int>(triangles_.size()));
  return triangles_[mesh];
}

void SceneBuffers::follow_topology(Session& session) {
  if (topology_ != session.topology_revision() || !session.engine().has_cells()) rebuild_topology(session);
}

// Returns true if anything was written.
bool SceneBuffers::write_surfaces(Session& session) {
  if (revision_ == session.revision()) return false;
  follow_topology(session);
  if (point_count_ > 0) {
    connect(points_, session);
    if (points_.shared) {
      session.drawing().draw_surfaces({points_.shared.get(), {}});
    } else {
      host_points_.resize(point_count_);
      session.drawing().draw_surfaces({nullptr, host_points_});
      glNamedBufferSubData(points_.name, 0, static_cast<GLsizeiptr>(points_.bytes), host_points_.data());
    }
  }
  revision_ = session.revision();
  return true;
}

int SceneBuffers::slot_of(Orientation orientation, int neighbour) {
  SIMPLEXSEG_EXPECT(neighbour >= -1 && neighbour <= 1);
  return neighbour == 0 ? static_cast<int>(orientation) : neighbour < 0 ? 3 : 4;
}

bool SceneBuffers::write_outlines(Session& session, OutlineState& state, Orientation orientation, double position_mm) {
  if (state.revision == session.revision() && state.orientation == orientation && state.position_mm == position_mm)
    return false;
  const int axis = slice_axes(orientation, Convention::Radiological).normal;
  follow_topology(session);
  const std::size_t meshes = triangles_.size();
  allocate(state.buffer, outline_bytes(meshes, vertex_count_));
  state.outlines = {state.buffer.name, meshes * sizeof(OutlineCommand)};
  if (state.buffer.name != 0) {
    connect(state.buffer, session);
    const auto position = static_cast<float>(position_mm);
    if (state.buffer.shared) {
      session.drawing().draw_outlines(axis, position, {state.buffer.shared.get(), {}});
    } else {
      host_outlines_.resize(state.buffer.bytes);
      session.drawing().draw_outlines(axis, position, {nullptr, host_outlines_});
      const auto upload = [&](std::size_t first, std::size_t bytes) {
        glNamedBufferSubData(state.buffer.name, static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes),
                             host_outlines_.data() + first);
      };
      upload(0, state.outlines.segments_at);
      for (std::size_t m = 0; m < meshes; ++m) {  // uploads only the segments in use, a small part of the buffer
        OutlineCommand command;
        std::memcpy(&command, host_outlines_.data() + m * sizeof command, sizeof command);
        if (command.segments > 0) {
          upload(state.outlines.segments_at + command.first_segment * sizeof(OutlineSegment),
                 command.segments * sizeof(OutlineSegment));
        }
      }
    }
  }
  state.revision = session.revision();
  state.orientation = orientation;
  state.position_mm = position_mm;
  return true;
}

void SceneBuffers::update_requested(Session& session, const ViewState& view) {
  const VolumeGeometry& geometry = session.volume().geometry();
  const auto position_mm = [&](int slot) {
    const Orientation orientation = outlines_[slot].requested_orientation;
    return slice_through_mm(view, geometry, orientation,
                            slot < 3 ? 0 : 2 * slot - 7)[slice_axes(orientation, Convention::Radiological).normal];
  };
  bool stale = surfaces_requested_ && revision_ != session.revision();
  for (int slot = 0; slot < kSliceSlots; ++slot) {
    const OutlineState& state = outlines_[slot];
    stale = stale || (state.requested &&
                      (state.revision != session.revision() || state.orientation != state.requested_orientation ||
                       state.position_mm != position_mm(slot)));
  }
  if (!stale) return;
  wait_for_readers();
  // Data that is not requested again before the next update is no longer visible.
  if (std::exchange(surfaces_requested_, false)) write_surfaces(session);
  for (int slot = 0; slot < kSliceSlots; ++slot) {
    OutlineState& state = outlines_[slot];
    if (std::exchange(state.requested, false))
      write_outlines(session, state, state.requested_orientation, position_mm(slot));
  }
  mark_written();
}

void SceneBuffers::update_surfaces(Session& session, const ViewState& view) {
  surfaces_requested_ = true;
  update_requested(session, view);
  surfaces_requested_ = true;
}

const SceneBuffers::Outlines& SceneBuffers::update_outlines(Session& session, const ViewState& view,
                                                            Orientation orientation, int neighbour) {
  OutlineState& state = outlines_[slot_of(orientation, neighbour)];
  state.requested = true;
  state.requested_orientation = orientation;
  update_requested(session, view);
  state.requested = true;
  return state.outlines;
}

const SceneBuffers::Slice& SceneBuffers::update_slice(Session& session, const ViewState& view, Orientation orientation,
                                                      int neighbour) {
  SIMPLEXSEG_EXPECT(!session.volume().empty());
  const VolumeGeometry& geometry = session.volume().geometry();
  return draw_slice(slices_[slot_of(orientation, neighbour)], session, view,
                    slice_grid(geometry, orientation, slice_through_mm(view, geometry, orientation, neighbour),
                               texels_per_voxel(geometry)));
}

const SceneBuffers::Slice& SceneBuffers::update_free_slice(Session& session, const ViewState& view,
                                                           const SliceGrid& grid) {
  return draw_slice(free_slice_, session, view, grid);
}

void SceneBuffers::release_free_slice() {
  if (free_slice_.slice.texture == 0) return;
  wait_for_readers();
  release(free_slice_);
}

const SceneBuffers::Slice& SceneBuffers::draw_slice(SliceState& state, Session& session, const ViewState& view,
                                                    const SliceGrid& grid) {
  SIMPLEXSEG_EXPECT(!session.volume().empty());
  if (state.valid && state.pixels.generation == session.engine_generation() && state.slice.grid == grid &&
      state.window == view.window && state.level == view.level && state.low_is_bright == view.low_is_bright) {
    return state.slice;
  }
  wait_for_readers();
  const VolumeGeometry& geometry = session.volume().geometry();
  Slice& slice = state.slice;
  state.valid = false;  // until it is drawn completely
  slice.grid = grid;
  const int width = slice.grid.width, height = slice.grid.height;
  const std::size_t texels = static_cast<std::size_t>(width) * height;
  allocate(state.pixels, texels * sizeof(DisplayTexel));
  if (slice.texture == 0 || state.width != width || state.height != height) {
    glDeleteTextures(1, &slice.texture);
    glCreateTextures(GL_TEXTURE_2D, 1, &slice.texture);
    // The 3D view uses a coarser mipmap level, the mean of several voxels.
    slice.mean_level = texels_per_voxel(geometry) > 1 ? 3 : 2;
    while (slice.mean_level > 0 && std::max(width, height) >> slice.mean_level == 0) --slice.mean_level;
    glTextureStorage2D(slice.texture, slice.mean_level + 1, GL_RG8, width, height);
    glTextureParameteri(slice.texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(slice.texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(slice.texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(slice.texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    state.width = width;
    state.height = height;
  }
  connect(state.pixels, session);
  SlicePlane plane = slice_plane(geometry, slice.grid, view.window, view.level);
  if (view.low_is_bright) std::swap(plane.low, plane.high);
  if (state.pixels.shared) {
    session.drawing().draw_slice(plane, {state.pixels.shared.get(), {}});
  } else {
    host_texels_.resize(texels);
    session.drawing().draw_slice(plane, {nullptr, host_texels_});
    glNamedBufferSubData(state.pixels.name, 0, static_cast<GLsizeiptr>(state.pixels.bytes), host_texels_.data());
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, state.pixels.name);
  glTextureSubImage2D(slice.texture, 0, 0, 0, width, height, GL_RG, GL_UNSIGNED_BYTE, nullptr);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glGenerateTextureMipmap(slice.texture);
  mark_written();
  state.valid = true;
  state.window = view.window;
  state.level = view.level;
  state.low_is_bright = view.low_is_bright;
  return slice;
}

const std::vector<LayerSlice>& SceneBuffers::update_layers(const SliceGrid& grid, std::span<const LayerSource> sources,
                                                           Orientation orientation, int neighbour) {
  return layers_.update(
      slot_of(orientation, neighbour), grid, sources, [this] { wait_for_readers(); }, [this] { mark_written(); });
}

void SceneBuffers::release_field() {
  glDeleteTextures(1, &field_.texture);
  field_ = {};
  shown_field_.reset();
}

const SceneBuffers::Field* SceneBuffers::update_field(const Session& session, const ViewState& view) {
  const MeshItem* const item = view.show_field ? session.scene_without_poses().find_mesh(view.active_mesh) : nullptr;
  if (!item || !item->visible || !item->has_field()) {
    if (shown_field_) release_field();
    return nullptr;
  }
  if (shown_field_ == item->field) return &field_;
  const MeshField& field = *item->field;
  const bool fits = shown_field_ && shown_field_->box.size == field.box.size;
  wait_for_readers();
  if (!fits) {
    release_field();
    glCreateTextures(GL_TEXTURE_3D, 1, &field_.texture);
    glTextureStorage3D(field_.texture, 1, GL_R16, field.box.size[0], field.box.size[1], field.box.size[2]);
    glTextureParameteri(field_.texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(field_.texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
      glTextureParameteri(field_.texture, axis, GL_CLAMP_TO_EDGE);
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTextureSubImage3D(field_.texture, 0, 0, 0, 0, field.box.size[0], field.box.size[1], field.box.size[2], GL_RED,
                      GL_UNSIGNED_SHORT, field.values.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  mark_written();
  field_.index_from_world = field.grid(session.volume().geometry()).index_from_world().matrix();
  shown_field_ = item->field;
  return &field_;
}

std::vector<OutlineSegment> SceneBuffers::read_outline(Orientation orientation, int mesh, int neighbour) const {
  const OutlineState& state = outlines_[slot_of(orientation, neighbour)];
  OutlineCommand command;
  // Number of meshes when this slice was last drawn; the scene may have more meshes now.
  const auto drawn = static_cast<int>(state.outlines.segments_at / sizeof command);
  if (state.buffer.name == 0 || mesh < 0 || mesh >= drawn) return {};
  begin_reading();
  glGetNamedBufferSubData(state.buffer.name, static_cast<GLintptr>(mesh * sizeof command), sizeof command, &command);
  std::vector<OutlineSegment> segments(command.segments);
  if (!segments.empty()) {
    glGetNamedBufferSubData(
        state.buffer.name,
        static_cast<GLintptr>(state.outlines.segments_at + command.first_segment * sizeof(OutlineSegment)),
        static_cast<GLsizeiptr>(segments.size() * sizeof(OutlineSegment)), segments.data());
  }
  return segments;
}

void SceneBuffers::invalidate_slices() {
  for (SliceState& state : slices_) state.valid = false;
  free_slice_.valid = false;
}

}  // namespace simplexseg
