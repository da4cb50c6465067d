// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "gui/drawing/cap_painter.h"
#include "gui/drawing/volume_painter.h"
#include "gui/look/clip_planes.h"

namespace simplexseg {

class DrawnScene;
class Workbench;

/// Meshes, their cut faces and the volume in the 3D view.
class SpaceSolids {
 public:
  SpaceSolids(Workbench& workbench, DrawnScene& drawn);
  void create();
  void destroy();
  /// Casts rays at reduced size, without VolumeMode::Shaded: the default with a software renderer.
  void set_reduced(bool reduced) { reduced_ = reduced; }
  bool reduced() const { return reduced_; }

  /// Updates the shared buffers, before anything is drawn. Needs a volume.
  void prepare();
  /// Draws everything; call it after opaque objects that end rays. `eye_mm`: position of the camera.
  void draw(const Projection& projection, const Eigen::Vector3d& eye_mm);
  /// Planes in use, as in the last prepare().
  const std::vector<ClipPlane>& planes() const { return planes_; }
  /// Coefficients of the planes in use except `but`.
  std::vector<Eigen::Vector4f> equations_except(CutPlane but) const;
  /// True if ViewState::surface_values colour the meshes.
  bool coloured() const { return coloured_; }
  /// Memory that volume rendering uses.
  std::size_t volume_bytes() const { return volume_.bytes(); }
  /// Indices of the visible meshes, largest first: smaller ones are drawn over cut faces of larger ones.
  std::vector<int> largest_first();

 private:
  enum class Opacity { Opaque, Translucent };
  bool poses_are_current() const;
  /// Updates order_ and boxes_.
  void measure_meshes();
  /// False if a plane cannot cut the mesh.
  bool may_cut(const ClipPlane& plane, int mesh) const;
  float opacity_of(int mesh) const;
  enum class Output { Colour, Depth };  ///< Depth: only depths matter, and translucent surfaces have them too
  void draw_meshes(const Projection& projection, Opacity opacity, Output output = Output::Colour) const;
  void draw_caps(const Projection& projection, const Eigen::Vector3d& eye_mm, Opacity opacity,
                 Output output = Output::Colour) const;
  void draw_volume_and_translucent(const Projection& projection, const Eigen::Vector3d& eye_mm);
  CapPainter::Plane cap_plane(const ClipPlane& plane, const Eigen::Vector3d& eye_mm) const;

  Workbench& workbench_;
  DrawnScene& drawn_;
  bool reduced_ = false;
  std::vector<ClipPlane> planes_;
  std::vector<Eigen::Vector4f> equations_;
  std::array<const SceneBuffers::Slice*, kCutPlanes> images_{};  ///< images of the cut faces
  const SceneBuffers* surfaces_ = nullptr;
  bool coloured_ = false;
  std::vector<Eigen::AlignedBox3f> boxes_;  ///< of all meshes, in the poses that were read last
  std::vector<int> order_;                  ///< visible meshes by the size of their boxes, largest first
  MeshPainter meshes_;
  CapPainter caps_;
  VolumePainter volume_;
};

/// Grid of a slice in any plane, over the whole volume: texels as large as the finest spacing, or larger, for at most
/// 512 texels per side.
SliceGrid plane_grid(const VolumeGeometry& geometry, const ClipPlane& plane);

}  // namespace simplexseg
