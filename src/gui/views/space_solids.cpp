// SPDX-License-Identifier: Apache-2.0
#include "gui/views/space_solids.h"

#include <algorithm>
#include <cmath>

#include "gui/look/slice_geometry.h"
#include "gui/views/drawn_scene.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

/// Unit vectors in a plane.
std::pair<Eigen::Vector3d, Eigen::Vector3d> axes_in(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d u = normal.unitOrthogonal();
  return {u, normal.cross(u)};
}

}  // namespace

SliceGrid plane_grid(const VolumeGeometry& geometry, const ClipPlane& plane) {
  constexpr double kMostTexels = 512;
  const auto [u, v] = axes_in(plane.normal);
  const Eigen::Affine3d world_from_index = geometry.world_from_index();
  Eigen::AlignedBox2d box;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int axis = 0; axis < 3; ++axis)
      index[axis] = (corner >> axis & 1) != 0 ? geometry.size[static_cast<std::size_t>(axis)] - 0.5 : -0.5;
    const Eigen::Vector3d at = world_from_index * index;
    box.extend(Eigen::Vector2d(u.dot(at), v.dot(at)));
  }
  const double step_mm = std::max(geometry.spacing_mm.minCoeff(), box.sizes().maxCoeff() / kMostTexels);
  SliceGrid grid;
  grid.width = std::max(1, static_cast<int>(std::ceil(box.sizes().x() / step_mm)));
  grid.height = std::max(1, static_cast<int>(std::ceil(box.sizes().y() / step_mm)));
  grid.step_u_mm = step_mm * u;
  grid.step_v_mm = step_mm * v;
  grid.origin_mm =
      plane.offset_mm * plane.normal + (box.min().x() + step_mm / 2) * u + (box.min().y() + step_mm / 2) * v;
  return grid;
}

SpaceSolids::SpaceSolids(Workbench& workbench, DrawnScene& drawn) : workbench_(workbench), drawn_(drawn) {}

void SpaceSolids::create() {
  meshes_.create();
  caps_.create();
  volume_.create();
  reduced_ = is_software_renderer();
}

void SpaceSolids::destroy() {
  meshes_.destroy();
  caps_.destroy();
  volume_.destroy();
}

void SpaceSolids::prepare() {
  const ViewState& view = workbench_.view;
  planes_ = clip_planes(view.clip, view.crosshair_mm);
  equations_.clear();
  images_ = {};
  std::optional<SliceGrid> free_grid;
  for (const ClipPlane& plane : planes_) {
    equations_.push_back(plane.equation());
    if (!view.clip.image_on_caps || !view.show_meshes || workbench_.scene().meshes.empty()) continue;
    if (plane.plane == CutPlane::Free)
      free_grid = plane_grid(workbench_.session().volume().geometry(), plane);
    else
      images_[static_cast<std::size_t>(plane.plane)] = drawn_.slice(static_cast<Orientation>(plane.plane));
  }
  images_[static_cast<std::size_t>(CutPlane::Free)] = drawn_.free_slice(free_grid);
  surfaces_ = view.show_meshes ? drawn_.surfaces() : nullptr;
  coloured_ = surfaces_ && view.surface_values && drawn_.surface_values();
  if (!planes_.empty()) measure_meshes();
}

// Reading poses from a device would delay a running simulation.
bool SpaceSolids::poses_are_current() const { return !(workbench_.running() && drawn_.buffers().on_device()); }

void SpaceSolids::measure_meshes() {
  const std::vector<MeshItem>& meshes =
      poses_are_current() ? workbench_.session().scene().meshes : workbench_.scene().meshes;
  boxes_.assign(meshes.size(), {});
  order_.clear();
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    if (!meshes[m].visible) continue;
    for (const Eigen::Vector3f& position : meshes[m].mesh.positions) boxes_[m].extend(position);
    order_.push_back(static_cast<int>(m));
  }
  const auto size = [&](int m) { return boxes_[static_cast<std::size_t>(m)].diagonal().norm(); };
  std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return size(a) > size(b); });
}

std::vector<int> SpaceSolids::largest_first() {
  measure_meshes();
  return order_;
}

bool SpaceSolids::may_cut(const ClipPlane& plane, int mesh) const {
  if (!poses_are_current()) return true;
  const Eigen::AlignedBox3d box = boxes_[static_cast<std::size_t>(mesh)].cast<double>();
  const double reach_mm = plane.normal.cwiseAbs().dot(box.sizes()) / 2;
  return std::abs(plane.beyond_mm(box.center())) <= reach_mm;
}

std::vector<Eigen::Vector4f> SpaceSolids::equations_except(CutPlane but) const {
  std::vector<Eigen::Vector4f> others;
  for (const ClipPlane& plane : planes_)
    if (plane.plane != but) others.push_back(plane.equation());
  return others;
}

float SpaceSolids::opacity_of(int mesh) const {
  return workbench_.scene().meshes[static_cast<std::size_t>(mesh)].opacity * workbench_.view.opacity;
}

void SpaceSolids::draw(const Projection& projection, const Eigen::Vector3d& eye_mm) {
  if (surfaces_) {
    draw_meshes(projection, Opacity::Opaque);
    draw_caps(projection, eye_mm, Opacity::Opaque);
  }
  draw_volume_and_translucent(projection, eye_mm);
}

void SpaceSolids::draw_volume_and_translucent(const Projection& projection, const Eigen::Vector3d& eye_mm) {
  const ViewState& view = workbench_.view;
  const bool with_volume =
      view.volume_mode != VolumeMode::Off && (!reduced_ || view.volume_mode == VolumeMode::Maximum);
  bool translucent = false;
  if (surfaces_)
    for (std::size_t m = 0; m < workbench_.scene().meshes.size(); ++m)
      translucent |= workbench_.scene().meshes[m].visible && opacity_of(static_cast<int>(m)) < 1;
  if (with_volume) {
    volume_.update(projection, workbench_.session().volume(), view, equations_, reduced_);
    volume_.take_depth();
    if (translucent) {
      volume_.add_depth([&] {
        draw_meshes(projection, Opacity::Translucent, Output::Depth);
        draw_caps(projection, eye_mm, Opacity::Translucent, Output::Depth);
      });
      volume_.draw(VolumePainter::Part::Behind);
    }
  } else {
    volume_.release();
  }
  if (translucent) {
    draw_meshes(projection, Opacity::Translucent);
    draw_caps(projection, eye_mm, Opacity::Translucent);
  }
  if (with_volume) volume_.draw(VolumePainter::Part::InFront);
}

void SpaceSolids::draw_meshes(const Projection& projection, Opacity opacity, Output output) const {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const float alpha = opacity_of(static_cast<int>(m));
    if (!meshes[m].visible || (alpha < 1) != (opacity == Opacity::Translucent)) continue;
    meshes_.draw(projection, *surfaces_, static_cast<int>(m),
                 rgba_of(meshes[m].colour, output == Output::Depth ? 1 : alpha),
                 coloured_ ? workbench_.view.surface_values->most_mm : 0, equations_);
  }
}

void SpaceSolids::draw_caps(const Projection& projection, const Eigen::Vector3d& eye_mm, Opacity opacity,
                            Output output) const {
  for (const ClipPlane& plane : planes_) {
    const CapPainter::Plane cap = cap_plane(plane, eye_mm);
    // An opaque surface hides the back of its cut face.
    if (!cap.faces_eye && (opacity == Opacity::Opaque || output == Output::Depth)) continue;
    const std::vector<Eigen::Vector4f> others = equations_except(plane.plane);
    for (const int m : order_) {
      const float alpha = opacity_of(m);
      if ((alpha < 1) != (opacity == Opacity::Translucent) || !may_cut(plane, m)) continue;
      caps_.draw(
          projection, *surfaces_, m, cap, others,
          rgba_of(workbench_.scene().meshes[static_cast<std::size_t>(m)].colour, output == Output::Depth ? 1 : alpha));
    }
  }
}

CapPainter::Plane SpaceSolids::cap_plane(const ClipPlane& plane, const Eigen::Vector3d& eye_mm) const {
  const WorldBox box = world_box(workbench_.session().volume().geometry());
  const auto [u, v] = axes_in(plane.normal);
  const Eigen::Vector3d centre = box.centre_mm() - plane.beyond_mm(box.centre_mm()) * plane.normal;
  const double reach_mm = 2 * box.extent_mm().norm();  // surfaces can leave the volume
  CapPainter::Plane cap;
  cap.equation = plane.equation();
  cap.corner_mm = (centre - reach_mm * (u + v)).cast<float>();
  cap.edge_u_mm = (2 * reach_mm * u).cast<float>();
  cap.edge_v_mm = (2 * reach_mm * v).cast<float>();
  cap.faces_eye = plane.beyond_mm(eye_mm) > 0;
  cap.image = images_[static_cast<std::size_t>(plane.plane)];
  return cap;
}

}  // namespace simplexseg
