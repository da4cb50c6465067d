// SPDX-License-Identifier: Apache-2.0
#include "image/surface_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/expect.h"
#include "image/volume.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

constexpr double kReachVoxels = 4, kStepVoxels = 0.5;
constexpr double kFarWeight = 0.7;  // weight of an edge at the end of the reach
constexpr double kFaintEdge = 0.2;  // weakest accepted edge, relative to the median over the vertices

struct Edge {
  double distance_mm, strength;
};

Edge strongest_edge(const Volume& volume, const Eigen::Vector3d& at, const Eigen::Vector3d& normal, double voxel_mm) {
  constexpr int kSide = static_cast<int>(kReachVoxels / kStepVoxels), kSamples = 2 * kSide + 3;
  const double step_mm = kStepVoxels * voxel_mm;
  double profile[kSamples];
  for (int n = 0; n < kSamples; ++n) profile[n] = volume.sample(at + (n - kSide - 1) * step_mm * normal);
  Edge best{kReachVoxels * voxel_mm, 0};
  for (int n = 1; n + 1 < kSamples; ++n) {
    const double distance_mm = std::abs(n - kSide - 1) * step_mm;
    const double change = std::abs(profile[n + 1] - profile[n - 1]);
    const double weighted = change * (1 - (1 - kFarWeight) * distance_mm / (kReachVoxels * voxel_mm));
    if (weighted > best.strength) best = {distance_mm, weighted};  // false for NaN
  }
  return best;
}

}  // namespace

std::optional<Intensities> intensities_in(const Volume& volume, const Mask& mask) {
  SIMPLEXSEG_EXPECT(mask.voxels.size() == volume.geometry().voxel_count());
  std::size_t count = 0;
  double mean = 0, squares = 0;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    for (std::size_t v = 0; v < voxels.size(); ++v) {
      const double value = static_cast<double>(voxels[v]);
      if (mask.voxels[v] == 0 || !std::isfinite(value)) continue;
      const double deviation = value - mean;
      mean += deviation / static_cast<double>(++count);
      squares += deviation * (value - mean);
    }
  });
  if (count == 0) return std::nullopt;
  return Intensities{mean, std::sqrt(squares / static_cast<double>(count)), count};
}

std::vector<float> edge_distances(const SimplexMesh& mesh, const Volume& volume) {
  SIMPLEXSEG_EXPECT(!volume.empty());
  const double voxel_mm = volume.geometry().spacing_mm.minCoeff();
  std::vector<Edge> edges;
  edges.reserve(mesh.positions.size());
  for (int v = 0; v < mesh.vertex_count(); ++v)
    edges.push_back(
        strongest_edge(volume, mesh.positions[v].cast<double>(), vertex_geometry(mesh, v).normal, voxel_mm));
  if (edges.empty()) return {};
  std::vector<double> strengths;
  strengths.reserve(edges.size());
  for (const Edge& edge : edges) strengths.push_back(edge.strength);
  std::nth_element(strengths.begin(), strengths.begin() + strengths.size() / 2, strengths.end());
  const double faint = kFaintEdge * strengths[strengths.size() / 2];
  std::vector<float> distances;
  distances.reserve(edges.size());
  for (const Edge& edge : edges)
    distances.push_back(
        static_cast<float>(edge.strength > 0 && edge.strength >= faint ? edge.distance_mm : kReachVoxels * voxel_mm));
  return distances;
}

std::vector<SurfaceLocation> worst_locations(const SimplexMesh& mesh, std::span<const float> values,
                                             std::size_t count) {
  SIMPLEXSEG_EXPECT(values.size() == mesh.positions.size());
  std::vector<double> smooth;
  smooth.reserve(values.size());
  for (const float value : values) smooth.push_back(std::isfinite(value) ? value : 0);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> mean(smooth.size());
    for (std::size_t v = 0; v < smooth.size(); ++v) {
      mean[v] = smooth[v];
      for (const int n : mesh.neighbours[v]) mean[v] += smooth[static_cast<std::size_t>(n)];
      mean[v] /= 4;
    }
    smooth = std::move(mean);
  }
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh.positions) box.extend(p);
  const double apart_mm = mesh.positions.empty() ? 0 : 0.1 * box.sizes().maxCoeff();
  std::vector<std::size_t> order(smooth.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return smooth[a] > smooth[b]; });
  std::vector<SurfaceLocation> places;
  for (const std::size_t v : order) {
    if (places.size() == count) break;
    const Eigen::Vector3d at = mesh.positions[v].cast<double>();
    const bool near = std::any_of(places.begin(), places.end(), [&](const SurfaceLocation& place) {
      return (place.position_mm - at).norm() < apart_mm;
    });
    if (!near) places.push_back({at, static_cast<float>(smooth[v])});
  }
  return places;
}

}  // namespace simplexseg
