// SPDX-License-Identifier: Apache-2.0
#include "app/slice_picture.h"

#include <algorithm>
#include <cmath>

#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

constexpr int kMaxRows = 4;
constexpr double kObjectMargin = 0.35;  ///< margin around objects, in their largest extent
constexpr int kGap = 4;                 ///< distance between panels, pixels

/// Plane of a slice, perpendicular to the world axis `across`. `right`, `down`: world axes (LPS) that point right and
/// down in the picture, multiplied by their signs.
struct Plane {
  int right, down, across;
  double right_sign, down_sign;
};
constexpr Plane kPlanes[] = {{0, 1, 2, 1, 1}, {1, 2, 0, 1, -1}, {0, 2, 1, 1, -1}};  // axial, sagittal, coronal

struct Box {
  Eigen::Vector3d low, high;
};

Box box_of(const VolumeGeometry& geometry) {
  Box box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};
  const Eigen::Affine3d world_from_index = geometry.world_from_index();
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int a = 0; a < 3; ++a) index[a] = (corner >> a & 1) ? geometry.size[a] - 0.5 : -0.5;
    const Eigen::Vector3d world = world_from_index * index;
    box.low = box.low.cwiseMin(world), box.high = box.high.cwiseMax(world);
  }
  return box;
}

/// Panel of the picture with one slice; pixel (0, 0) is the upper left corner of the panel.
struct Panel {
  Plane plane;
  Eigen::Vector3d corner_mm;  ///< world position of the upper left corner, in the plane of the slice
  double pixel_mm;
  int left, top, width, height;  ///< rectangle in the picture, pixels

  Eigen::Vector3d world_of(double x, double y) const {
    Eigen::Vector3d world = corner_mm;
    world[plane.right] += plane.right_sign * x * pixel_mm;
    world[plane.down] += plane.down_sign * y * pixel_mm;
    return world;
  }
  Eigen::Vector2d pixel_of(const Eigen::Vector3d& world) const {
    return {(world[plane.right] - corner_mm[plane.right]) * plane.right_sign / pixel_mm,
            (world[plane.down] - corner_mm[plane.down]) * plane.down_sign / pixel_mm};
  }
};

Panel panel_at(const Plane& plane, const Box& box, const Eigen::Vector3d& focus, double pixel_mm) {
  Panel panel{plane, focus, pixel_mm, 0, 0, 0, 0};
  const auto start = [&box](int axis, double sign) { return sign > 0 ? box.low[axis] : box.high[axis]; };
  panel.corner_mm[plane.right] = start(plane.right, plane.right_sign);
  panel.corner_mm[plane.down] = start(plane.down, plane.down_sign);
  const Eigen::Vector3d extent = box.high - box.low;
  panel.width = std::max(1, static_cast<int>(std::lround(extent[plane.right] / pixel_mm)));
  panel.height = std::max(1, static_cast<int>(std::lround(extent[plane.down] / pixel_mm)));
  return panel;
}

class Canvas {
 public:
  explicit Canvas(Picture& picture) : picture_(picture) {}

  void set(const Panel& panel, int x, int y, const Colour& colour) {
    if (x < 0 || y < 0 || x >= panel.width || y >= panel.height) return;
    std::uint8_t* const pixel =
        &picture_.rgb[3 * (static_cast<std::size_t>(panel.top + y) * picture_.width + panel.left + x)];
    pixel[0] = colour.red, pixel[1] = colour.green, pixel[2] = colour.blue;
  }
  void line(const Panel& panel, const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Colour& colour) {
    const double length = std::min((b - a).cwiseAbs().maxCoeff(), 1e5);
    const int steps = static_cast<int>(length * 2) + 1;
    for (int s = 0; s <= steps; ++s) {
      const Eigen::Vector2d p = a + (b - a) * s / steps;
      set(panel, static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())), colour);
    }
  }

 private:
  Picture& picture_;
};

struct Window {
  double low, high;
  std::uint8_t grey(double value) const {
    return static_cast<std::uint8_t>(std::clamp((value - low) / (high - low), 0.0, 1.0) * 255);
  }
};

/// Intensity window: 1st to 99th percentile of a sample of the voxels, excluding voxels with the lowest value.
Window window_of(const Volume& volume) {
  std::vector<double> values;
  const auto& size = volume.geometry().size;
  const auto stride = [](int n) { return std::max(1, n / 64); };
  const double darkest = volume.range().min;
  for (int k = 0; k < size[2]; k += stride(size[2]))
    for (int j = 0; j < size[1]; j += stride(size[1]))
      for (int i = 0; i < size[0]; i += stride(size[0])) {
        const double value = volume.value(i, j, k);
        if (std::isfinite(value) && value > darkest) values.push_back(value);
      }
  if (values.empty()) return {darkest, darkest + 1};
  std::sort(values.begin(), values.end());
  const double low = values[values.size() / 100], high = values[values.size() - 1 - values.size() / 100];
  return {std::min(low, high - 1e-9 * std::max(1.0, std::abs(high))), high};
}

void draw_volume(Canvas& canvas, const Panel& panel, const Volume& volume, const Window& window,
                 const LayerPicture& layers) {
  for (int y = 0; y < panel.height; ++y)
    for (int x = 0; x < panel.width; ++x) {
      const Eigen::Vector3d world = panel.world_of(x + 0.5, y + 0.5);
      if (!volume.geometry().contains(world)) continue;
      const std::uint8_t grey = window.grey(volume.sample(world));
      canvas.set(panel, x, y, layers.over({grey, grey, grey}, world));
    }
}

/// Draws the intersection of the plane of the slice with each triangle.
void draw_outline(Canvas& canvas, const Panel& panel, const TriangleMesh& surface, const Colour& colour) {
  const int axis = panel.plane.across;
  const double level = panel.corner_mm[axis];
  for (const auto& triangle : surface.triangles) {
    Eigen::Vector2d ends[3];
    int count = 0;
    for (int e = 0; e < 3; ++e) {
      const Eigen::Vector3d a = surface.positions[triangle[e]].cast<double>();
      const Eigen::Vector3d b = surface.positions[triangle[(e + 1) % 3]].cast<double>();
      if ((a[axis] < level) == (b[axis] < level)) continue;
      ends[count++] = panel.pixel_of(a + (b - a) * ((level - a[axis]) / (b[axis] - a[axis])));
    }
    if (count == 2) canvas.line(panel, ends[0], ends[1], colour);
  }
}

}  // namespace

Picture draw_slices(const Volume& volume, const Scene& scene, bool low_is_bright, int panel, const LayerPicture& layers,
                    SliceFrame frame) {
  std::vector<TriangleMesh> surfaces;
  std::vector<Colour> colours;
  std::vector<Eigen::Vector3d> foci;
  Box box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};  // of the meshes
  for (const MeshItem& item : scene.meshes) {
    if (!item.visible || item.mesh.positions.empty()) continue;
    surfaces.push_back(tessellate(item.mesh));
    colours.push_back(item.colour);
    if (static_cast<int>(foci.size()) < kMaxRows) foci.push_back(measure(item.mesh).centroid_mm);
    for (const Eigen::Vector3f& p : item.mesh.positions) {
      box.low = box.low.cwiseMin(p.cast<double>()), box.high = box.high.cwiseMax(p.cast<double>());
    }
  }
  if (!volume.empty()) {
    const Box whole = box_of(volume.geometry());
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kObjectMargin * (box.high - box.low).maxCoeff());
    const Box around{(box.low - margin).cwiseMax(whole.low), (box.high + margin).cwiseMin(whole.high)};
    const bool is_inside = !surfaces.empty() && (around.high - around.low).minCoeff() > 0;
    box = frame == SliceFrame::Objects && is_inside ? around : whole;
  }
  if (volume.empty() && surfaces.empty()) box = {Eigen::Vector3d::Constant(-1), Eigen::Vector3d::Constant(1)};
  if (foci.empty()) foci.push_back((box.low + box.high) / 2);

  const double pixel_mm = std::max((box.high - box.low).maxCoeff(), 1e-6) / std::max(1, panel);
  Picture picture;
  std::vector<Panel> panels;
  for (const Eigen::Vector3d& focus : foci) {
    int left = 0, row_height = 0;
    for (const Plane& plane : kPlanes) {
      Panel next = panel_at(plane, box, focus, pixel_mm);
      next.left = left, next.top = picture.height;
      left += next.width + kGap;
      row_height = std::max(row_height, next.height);
      panels.push_back(next);
    }
    picture.width = left - kGap;
    picture.height += row_height + kGap;
  }
  picture.height -= kGap;
  picture.rgb.assign(3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height),
                     frame == SliceFrame::Objects ? 255 : 0);
  Canvas canvas(picture);
  Window window = volume.empty() ? Window{0, 1} : window_of(volume);
  if (low_is_bright) std::swap(window.low, window.high);
  for (const Panel& one : panels) {
    if (!volume.empty()) draw_volume(canvas, one, volume, window, layers);
    for (std::size_t s = 0; s < surfaces.size(); ++s) draw_outline(canvas, one, surfaces[s], colours[s]);
  }
  return picture;
}

}  // namespace simplexseg
