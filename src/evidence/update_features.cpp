// SPDX-License-Identifier: Apache-2.0
#include "evidence/update_features.h"

#include <algorithm>

#include "evidence/geodesic_distance.h"
#include "evidence/mark_measures.h"
#include "image/distance_map.h"

namespace simplexseg {
namespace {

constexpr int kUpdateRounds = 3;

std::vector<float> distance_to(const std::vector<std::uint8_t>& set, const PriorInput& input) {
  Eigen::Matrix3d mm = Eigen::Matrix3d::Zero();
  for (int a = 0; a < 3; ++a) mm(a, a) = input.spacing_mm[a];
  return distance_map(set, VoxelBox{{0, 0, 0}, input.grid.size}, mm);
}

}  // namespace

UpdateFeatures::UpdateFeatures(const PriorInput& input, std::span<const std::uint8_t> anew,
                               const EvidenceSettings& settings, const RunJobs& run)
    : nearest_(input.known.size()),
      square_(input.known.size(), 1e12f),
      edges_(input.known.size(), start_of_way(false)),
      inward_(input.known.size()) {
  const float least_mm = static_cast<float>(*std::min_element(input.spacing_mm.begin(), input.spacing_mm.end()));
  const int n = static_cast<int>(input.known.size());
  for (std::size_t m = 0; m < input.fresh.size(); ++m) {
    const FreshMark& mark = input.fresh[m];
    balls_.push_back(mark.ball);
    edges_[mark.ball.voxel] = 0;
    for (int v = 0; v < n; ++v) {
      const float square = mark.square_mm[v];
      if (square < square_[v]) square_[v] = square, nearest_[v] = static_cast<std::uint16_t>(m);
      if (square <= mark.ball.radius_mm * mark.ball.radius_mm) edges_[v] = 0;
    }
  }
  const EdgeCost cost = cost_of_edges(noise_of(input.inner_difference));
  view_ = {input.image.data(),
           input.before.data(),
           anew.data(),
           balls_.data(),
           nearest_.data(),
           square_.data(),
           edges_.data(),
           inward_.data(),
           static_cast<float>(1 / input.reach_mm),
           least_mm,
           1 / cost.edge,
           static_cast<float>(input.balls.size()),
           static_cast<float>(settings.far_memory),
           static_cast<float>(settings.far_depths)};
  std::vector<std::uint8_t> in(n), out(n);
  for (int v = 0; v < n; ++v) in[v] = input.before[v] > kPreviousThreshold, out[v] = !in[v];
  run(3, [&](int job) {
    if (job == 0) lower_geodesic_distance(edges_, input.image, input.grid, input.spacing_mm, cost, kUpdateRounds);
    if (job == 0) return;
    const std::vector<float> to_other = distance_to(job == 1 ? out : in, input);
    const std::uint8_t* const mine = job == 1 ? in.data() : out.data();
    for (int v = 0; v < n; ++v)
      if (mine[v]) inward_[v] = inward_mm(to_other[v], job == 1, least_mm);
  });
}

void UpdateFeatures::fill(int first, int count, FeatureRows& to) const {
  for (int l = 0; l < count; ++l) view_.fill(first + l, [&to, l](int f, float value) { to[f][l] = value; });
}

}  // namespace simplexseg
