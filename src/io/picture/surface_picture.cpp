// SPDX-License-Identifier: Apache-2.0
#include "io/picture/surface_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace simplexseg {
namespace {

constexpr int kSamples = 2;                        ///< along each edge of a pixel
constexpr float kAmbient = 0.3f, kDiffuse = 0.7f;  ///< shares of light

/// Unit normals of the points, from the areas of their triangles.
std::vector<Eigen::Vector3f> point_normals(const TriangleMesh& surface) {
  std::vector<Eigen::Vector3f> normals(surface.positions.size(), Eigen::Vector3f::Zero());
  for (const std::array<int, 3>& t : surface.triangles) {
    const Eigen::Vector3f a = surface.positions[t[0]], b = surface.positions[t[1]], c = surface.positions[t[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a);
    for (const int p : t) normals[p] += normal;
  }
  for (Eigen::Vector3f& n : normals) n.normalize();
  return normals;
}

/// Square of samples with their depths.
struct Samples {
  explicit Samples(int edge)
      : edge(edge), depth(std::size_t(edge) * edge, -std::numeric_limits<float>::infinity()), rgb(depth.size()) {}
  int edge;
  std::vector<float> depth;          ///< towards the viewer
  std::vector<Eigen::Vector3f> rgb;  ///< 0..255, where depth is finite
};

struct ShadedPoint {
  Eigen::Vector3f at;  ///< sample coordinates and depth
  Eigen::Vector3f rgb;
};

void draw_triangle(Samples& samples, const std::array<ShadedPoint, 3>& p) {
  const Eigen::Vector2f a = p[0].at.head<2>(), b = p[1].at.head<2>(), c = p[2].at.head<2>();
  const auto cross = [](const Eigen::Vector2f& u, const Eigen::Vector2f& v) { return u.x() * v.y() - u.y() * v.x(); };
  const float area = cross(b - a, c - a);
  if (area == 0) return;
  const auto range = [&](int axis) {
    const auto [low, high] = std::minmax({a[axis], b[axis], c[axis]});
    return std::array{std::max(0, static_cast<int>(std::floor(low))),
                      std::min(samples.edge - 1, static_cast<int>(std::ceil(high)))};
  };
  const auto [x0, x1] = range(0);
  const auto [y0, y1] = range(1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2f at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
      const float u = cross(b - at, c - at) / area, v = cross(c - at, a - at) / area, w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      const float depth = u * p[0].at.z() + v * p[1].at.z() + w * p[2].at.z();
      const std::size_t s = std::size_t(y) * samples.edge + x;
      if (depth <= samples.depth[s]) continue;
      samples.depth[s] = depth;
      samples.rgb[s] = u * p[0].rgb + v * p[1].rgb + w * p[2].rgb;
    }
}

}  // namespace

// Patient frame: x to the left, y to the back, z to the head.
Eigen::Matrix3f view_from_front() {
  Eigen::Matrix3f rows;
  rows << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return rows;
}
Eigen::Matrix3f view_from_left() {
  Eigen::Matrix3f rows;
  rows << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return rows;
}

void draw_surface(Picture& picture, int left, int top, int size, const TriangleMesh& surface,
                  const std::vector<Colour>& colours, const SurfaceView& view) {
  Samples samples(size * kSamples);
  const float scale = 0.5f * static_cast<float>(samples.edge) / view.half_width_mm;
  const std::vector<Eigen::Vector3f> normals = point_normals(surface);
  std::vector<ShadedPoint> points;
  points.reserve(surface.positions.size());
  for (std::size_t p = 0; p < surface.positions.size(); ++p) {
    const Eigen::Vector3f seen = scale * (view.rotation * (surface.positions[p] - view.centre_mm));
    const float half = 0.5f * static_cast<float>(samples.edge);
    const float light = kAmbient + kDiffuse * std::max(0.0f, (view.rotation * normals[p]).z());
    const auto [r, g, b] = colours[p];
    points.push_back({{half + seen.x(), half - seen.y(), seen.z()}, light * Eigen::Vector3f(r, g, b)});
  }
  for (const std::array<int, 3>& t : surface.triangles)
    draw_triangle(samples, {points[t[0]], points[t[1]], points[t[2]]});
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      std::uint8_t* const pixel = &picture.rgb[3 * (std::size_t(top + y) * picture.width + left + x)];
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i) {
          const std::size_t s = std::size_t(y * kSamples + j) * samples.edge + x * kSamples + i;
          sum += std::isfinite(samples.depth[s]) ? samples.rgb[s] : Eigen::Vector3f(pixel[0], pixel[1], pixel[2]);
        }
      sum /= kSamples * kSamples;
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(std::lround(std::clamp(sum[c], 0.0f, 255.0f)));
    }
}

}  // namespace simplexseg
