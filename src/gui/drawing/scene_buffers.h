// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gui/drawing/layer_slices.h"
#include "gui/look/slice_geometry.h"
#include "mesh/simplex_mesh.h"
#include "step/display.h"

struct __GLsync;

namespace simplexseg {

class Session;
struct MeshField;
struct SurfaceValues;
struct ViewState;

/// OpenGL buffers of the surfaces and the three slices. The engine fills them on the device if possible, otherwise
/// through host memory. The contexts of all views share them; each call needs one of these contexts to be current. The
/// first view of a frame updates them for all views.
class SceneBuffers {
 public:
  /// Range of one mesh in indices().
  struct Range {
    std::size_t first = 0;
    int count = 0;
  };
  struct Slice {
    SliceGrid grid;
    unsigned texture = 0;  ///< red: grey value; green: 1 inside the volume
    int mean_level = 0;    ///< mipmap level at which a texel is the mean of several voxels
  };

  /// Registers and unregisters a view; the last one to detach deletes the buffers.
  void attach(const void* view);
  void detach(const void* view);
  // begin_reading() and end_reading() enclose each frame of a view. The contexts synchronise on the GPU; the host never
  // waits.

  void begin_reading() const;
  void end_reading(const void* view);

  // update_surfaces() and update_outlines() also update the surfaces and contours that the other views used in their
  // last frame: the engine writes all of them at once, because a device switches slowly between computing and drawing.
  // All functions pass on the errors of the engine.

  /// Updates the surfaces to the current pose of the session.
  void update_surfaces(Session& session, const ViewState& view);
  /// Slice through the crosshair, or a neighbour of it (slice_through_mm()). Drawn again only if its position, window,
  /// level or the engine has changed, or after invalidate_slices(). Needs a volume. All views show the neighbours of
  /// one orientation.
  const Slice& update_slice(Session& session, const ViewState& view, Orientation orientation, int neighbour = 0);
  /// Slice in any other plane, drawn again like those through the crosshair.
  const Slice& update_free_slice(Session& session, const ViewState& view, const SliceGrid& grid);
  void release_free_slice();
  /// Sections of layers in such a slice, whose grid is `grid`; see LayerSlices::update().
  const std::vector<LayerSlice>& update_layers(const SliceGrid& grid, std::span<const LayerSource> sources,
                                               Orientation orientation, int neighbour);
  /// Contours of the surfaces in a slice, for OutlinePainter.
  struct Outlines {
    unsigned buffer = 0;          ///< draw commands, then segments (step/display.h); 0 without meshes
    std::size_t segments_at = 0;  ///< offset of the segments, bytes
  };
  /// Contours in such a slice.
  const Outlines& update_outlines(Session& session, const ViewState& view, Orientation orientation, int neighbour = 0);
  /// Field of the active mesh, for FieldPainter.
  struct Field {
    unsigned texture = 0;  ///< 3D, 16 bits per voxel, scaled as in FieldBox (forces/step_view.h)
    Eigen::Matrix4d index_from_world = Eigen::Matrix4d::Identity();  ///< index in the texture
  };
  /// Uploads the field if it has changed. Returns null, and releases the texture, while no field is shown.
  const Field* update_field(const Session& session, const ViewState& view);
  /// Uploads the values that colour the surfaces, if they have changed; call it after update_surfaces(). Returns false
  /// without values.
  bool update_values(const Session& session, const std::shared_ptr<const SurfaceValues>& values);
  /// Buffer with a value (float) for each of points(), negative where unknown.
  unsigned values() const { return values_; }
  /// Reads back the segments of the last drawn contour of the mesh with index `mesh` in the scene.
  std::vector<OutlineSegment> read_outline(Orientation orientation, int mesh, int neighbour = 0) const;
  /// Marks all slices as outdated, for a new volume.
  void invalidate_slices();

  /// Buffer of the vertices of all meshes, then the cell centres of all meshes (DisplayPoint); 0 without meshes.
  unsigned points() const { return points_.name; }
  /// Buffer of the indices (32 bits) of the 3V triangles (cell centre, a, b) of each mesh with V vertices.
  unsigned indices() const { return indices_; }
  /// Range of the triangles of the mesh with index `mesh` in the scene.
  const Range& triangles(int mesh) const;

  /// Returns true if the engine writes the buffers directly on the device.
  bool on_device() const { return on_device_; }
  /// Text "drawn on the device (CUDA writes into OpenGL)", or "uploaded each frame" with the reason; empty before the
  /// first frame.
  const std::string& transfer_mode() const { return transfer_mode_; }
  /// Name of the OpenGL renderer, such as "llvmpipe ..."; empty before the first view.
  const std::string& renderer() const { return renderer_; }

 private:
  struct Buffer {
    unsigned name = 0;
    std::size_t bytes = 0;
    std::unique_ptr<SharedBuffer> shared;  ///< null: upload
    int generation = -1;                   ///< engine that shares the buffer (Session::engine_generation())
  };
  struct SliceState {
    Slice slice;
    Buffer pixels;
    int width = 0, height = 0;  ///< size of the texture
    bool valid = false;
    double window = 0, level = 0;
    bool low_is_bright = false;
  };
  struct OutlineState {
    Outlines outlines;
    Buffer buffer;
    std::uint64_t revision = ~std::uint64_t{0};
    Orientation orientation = Orientation::Axial;
    double position_mm = 0;
    bool requested = false;
    Orientation requested_orientation = Orientation::Axial;
  };
  static constexpr int kSliceSlots = 5;
  /// Index of the buffers of a slice: of the three through the crosshair, then of the previous and the next one.
  static int slot_of(Orientation orientation, int neighbour);
  static void release(Buffer& buffer);
  static void allocate(Buffer& buffer, std::size_t bytes);
  void connect(Buffer& buffer, Session& session);
  void update_requested(Session& session, const ViewState& view);
  static void release(SliceState& state);
  const Slice& draw_slice(SliceState& state, Session& session, const ViewState& view, const SliceGrid& grid);
  bool write_surfaces(Session& session);
  bool write_outlines(Session& session, OutlineState& state, Orientation orientation, double position_mm);
  void follow_topology(Session& session);
  void rebuild_topology(Session& session);
  void wait_for_readers();
  void mark_written();
  void release_field();
  void release_all();

  Buffer points_;
  unsigned indices_ = 0;
  std::vector<Range> triangles_;
  std::vector<CellList> cells_;
  unsigned values_ = 0;
  std::shared_ptr<const SurfaceValues> shown_values_;  ///< contents of values_
  std::uint64_t values_topology_ = ~std::uint64_t{0};
  std::size_t point_count_ = 0;
  std::uint64_t revision_ = ~std::uint64_t{0}, topology_ = ~std::uint64_t{0};
  std::size_t vertex_count_ = 0;
  bool surfaces_requested_ = false;
  SliceState slices_[kSliceSlots], free_slice_;  ///< the first by slot_of()
  OutlineState outlines_[kSliceSlots];
  Field field_;
  std::shared_ptr<const MeshField> shown_field_;  ///< contents of the texture; null: no texture
  LayerSlices layers_;
  std::vector<DisplayPoint> host_points_;  ///< staging memory of the upload
  std::vector<DisplayTexel> host_texels_;
  std::vector<std::byte> host_outlines_;

  std::map<const void*, __GLsync*> views_;  ///< views, each with the fence after its last read
  __GLsync* written_ = nullptr;
  bool on_device_ = false;
  std::string transfer_mode_, renderer_;
};

}  // namespace simplexseg
