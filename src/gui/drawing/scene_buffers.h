// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gui/look/slice_geometry.h"
#include "mesh/simplex_mesh.h"
#include "step/display.h"

struct __GLsync;

namespace simplexseg {

class Session;
struct MeshField;
struct SurfaceValues;
struct ViewState;

/// What all views draw from: the surfaces and the three slices in OpenGL buffers that the engine fills, in place on the
/// device where it can, else through host memory. The views' contexts share them; all calls need one of these current.
/// Whoever draws first in a frame brings them up to date, once for all.
class SceneBuffers {
 public:
  /// Where the indices of one mesh lie in indices().
  struct Range {
    std::size_t first = 0;
    int count = 0;
  };
  struct Slice {
    SliceGrid grid;
    unsigned texture = 0;  ///< red: grey, green: 1 inside the volume
    int mean_level = 0;    ///< at which a texel is the mean of some voxels
  };

  /// A view begins to draw from the buffers; the last one that leaves deletes them.
  void attach(const void* view);
  void detach(const void* view);
  // These two stand around each frame of a view: the contexts wait for each other on the GPU, never here.

  void begin_reading() const;
  void end_reading(const void* view);

  // Each brings up to date with it what the other views wanted for their last frame: all that the engine writes in a
  // frame it writes at once, for a device changes slowly between computing and drawing. They throw what the engine
  // throws.

  /// Surfaces in the session's present pose.
  void update_surfaces(Session& session, const ViewState& view);
  /// The slice through the crosshair, with window and level; drawn anew only when one of these has changed. There must
  /// be a volume.
  const Slice& update_slice(Session& session, const ViewState& view, Orientation orientation);
  /// Where the slice through the crosshair cuts the surfaces, for OutlinePainter.
  struct Outlines {
    unsigned buffer = 0;        ///< commands, then pieces (step/display.h); 0 when there is no mesh
    std::size_t pieces_at = 0;  ///< bytes
  };
  const Outlines& update_outlines(Session& session, const ViewState& view, Orientation orientation);
  /// The field of the active mesh, for FieldPainter.
  struct Field {
    unsigned texture = 0;  ///< 3D, 16 bits a voxel, as FieldBox says (forces/step_view.h)
    Eigen::Matrix4d index_from_world = Eigen::Matrix4d::Identity();
    Eigen::Vector3f first_voxel{0, 0, 0};
  };
  /// Uploads the field when it has changed. Null, with nothing held, while it is not shown or there is none.
  const Field* update_field(const Session& session, const ViewState& view);
  /// Uploads what the surfaces are coloured by, when it has changed; after update_surfaces(). False where there is
  /// nothing to colour by.
  bool update_values(const Session& session, const std::shared_ptr<const SurfaceValues>& values);
  /// A value for each of points(), below 0 where none is known.
  unsigned values() const { return values_; }
  /// The pieces of the outline that was drawn last of the mesh at this place in the scene's list.
  std::vector<OutlinePiece> read_outline(Orientation orientation, int mesh) const;
  /// The volume is another one.
  void forget_slices();

  /// The vertices mesh by mesh, then the cells' centres mesh by mesh (DisplayPoint); 0 when there is no mesh.
  unsigned points() const { return points_.name; }
  /// 3V triangles (centre of the cell, a, b) of each mesh, 32 bits an index.
  unsigned indices() const { return indices_; }
  /// Those of the mesh that has this place in the scene's list.
  const Range& triangles(int mesh) const;

  /// Whether the engine writes the buffers itself.
  bool on_device() const { return on_device_; }
  /// "drawn on the device (CUDA writes into OpenGL)", or "uploaded each frame" with the reason. Empty before the first.
  const std::string& how() const { return how_; }
  /// What draws, as OpenGL names it: "llvmpipe ...". Empty before the first view.
  const std::string& renderer() const { return renderer_; }

 private:
  struct Buffer {
    unsigned name = 0;
    std::size_t bytes = 0;
    std::unique_ptr<SharedBuffer> shared;  ///< null: upload
    int generation = -1;                   ///< which engine was asked (Session::engine_generation)
  };
  struct SliceState {
    Slice slice;
    Buffer pixels;
    int width = 0, height = 0;  ///< the size of the texture
    bool valid = false;
    double position_mm = 0, window = 0, level = 0;
  };
  struct OutlineState {
    Outlines outlines;
    Buffer buffer;
    std::uint64_t revision = ~std::uint64_t{0};
    double position_mm = 0;
    bool wanted = false;
  };
  static void release(Buffer& buffer);
  static void allocate(Buffer& buffer, std::size_t bytes);
  void connect(Buffer& buffer, Session& session);
  void update_wanted(Session& session, const ViewState& view);
  bool write_surfaces(Session& session);
  bool write_outlines(Session& session, const ViewState& view, Orientation orientation);
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
  std::shared_ptr<const SurfaceValues> shown_values_;  ///< what is in it
  std::uint64_t values_topology_ = ~std::uint64_t{0};
  std::size_t point_count_ = 0;
  std::uint64_t revision_ = ~std::uint64_t{0}, topology_ = ~std::uint64_t{0};
  std::size_t vertex_count_ = 0;
  bool surfaces_wanted_ = false;
  SliceState slices_[3];
  OutlineState outlines_[3];
  Field field_;
  std::shared_ptr<const MeshField> shown_field_;  ///< what its texture has; null: there is no texture
  std::vector<DisplayPoint> host_points_;         ///< for the upload
  std::vector<DisplayTexel> host_texels_;
  std::vector<std::byte> host_outlines_;

  std::map<const void*, __GLsync*> views_;  ///< with the end of what each has read
  __GLsync* written_ = nullptr;
  bool on_device_ = false;
  std::string how_, renderer_;
};

}  // namespace simplexseg
