// SPDX-License-Identifier: Apache-2.0
#include "evidence/update_features.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"
#include "evidence/geodesic_distance.h"
#include "image/distance_map.h"

namespace simplexseg {
namespace {

constexpr int kRounds = 3;
constexpr float kUnreached = 1e4f, kEdgeLengthCost = 0.002f;

std::vector<float> distance_to(const std::vector<std::uint8_t>& set, const PriorInput& input) {
  Eigen::Matrix3d mm = Eigen::Matrix3d::Zero();
  for (int a = 0; a < 3; ++a) mm(a, a) = input.spacing_mm[a];
  return distance_map(set, VoxelBox{{0, 0, 0}, input.grid.size}, mm);
}

}  // namespace

UpdateFeatures::UpdateFeatures(const PriorInput& input, std::span<const std::uint8_t> anew, const RunJobs& run)
    : input_(input),
      anew_(anew),
      nearest_(input.known.size()),
      square_(input.known.size(), 1e12f),
      edges_(input.known.size(), kUnreached),
      inward_(input.known.size()),
      per_radius_(static_cast<float>(1 / input.reach_mm)),
      least_mm_(static_cast<float>(*std::min_element(input.spacing_mm.begin(), input.spacing_mm.end()))),
      marks_(static_cast<float>(input.balls.size())) {
  const int n = static_cast<int>(input.known.size());
  for (std::size_t m = 0; m < input.fresh.size(); ++m) {
    const FreshMark& mark = input.fresh[m];
    edges_[mark.voxel] = 0;
    for (int v = 0; v < n; ++v) {
      const float square = mark.square_mm[v];
      if (square < square_[v]) square_[v] = square, nearest_[v] = static_cast<std::uint16_t>(m);
      if (square <= mark.radius_mm * mark.radius_mm) edges_[v] = 0;
    }
  }
  const float noise = input.inner_difference + 0.01f;  // and an edge far above it
  per_noise_ = 1 / (3 * noise);
  std::vector<std::uint8_t> in(n), out(n);
  for (int v = 0; v < n; ++v) in[v] = input.before[v] > kMiddleBefore, out[v] = !in[v];
  run(3, [&](int job) {
    if (job == 0)
      lower_geodesic_distance(edges_, input.image, input.grid, input.spacing_mm, {kEdgeLengthCost, 3 * noise}, kRounds);
    // The surface lies half way between voxels.
    const float half = 0.5f * least_mm_;
    if (job == 0) return;
    const std::vector<float> to_other = distance_to(job == 1 ? out : in, input);
    const std::uint8_t* const mine = job == 1 ? in.data() : out.data();
    for (int v = 0; v < n; ++v)
      if (mine[v]) inward_[v] = (smaller(to_other[v], 1e6f) - half) * (job == 1 ? 1.0f : -1.0f);
  });
}

void UpdateFeatures::fill(int first, int count, FeatureRows& to) const {
  for (int l = 0; l < count; ++l) {
    const int v = first + l;
    const FreshMark& mark = input_.fresh[nearest_[v]];
    const float depth = depth_of(v), side = mark.inside ? 1.0f : -1.0f;
    const float p = (anew_[v] + 0.5f) / 256, away = side * inward_[v];
    const float before = input_.before[v] == 0 ? -1.0f : (input_.before[v] - 128) / 127.0f;
    const float distance = std::sqrt(square_[v]);
    const float across = away / depth;  // of the mark itself about -1
    const float along = std::sqrt(larger(square_[v] / (depth * depth) - (across + 1) * (across + 1), 0.0f));
    to[0][l] = side * std::log(p / (1 - p));
    to[1][l] = side * before;
    to[2][l] = smaller(larger(across, -8.0f), 8.0f);
    to[3][l] = std::log(distance / depth + 0.2f);
    to[4][l] = std::log(distance * per_radius_ + 0.05f);
    to[5][l] = std::log(edges_[v] + 0.05f);
    to[6][l] = smaller(std::fabs(input_.image[v] - mark.look) * per_noise_, 5.0f);
    to[7][l] = std::log(depth * per_radius_);
    to[8][l] = std::log(along + 0.3f);
    to[9][l] = std::log(depth / least_mm_);
    to[10][l] = std::log(marks_);
    to[11][l] = smaller(larger(away / least_mm_, -8.0f), 8.0f);
  }
}

}  // namespace simplexseg
