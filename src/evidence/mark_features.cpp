// SPDX-License-Identifier: Apache-2.0
#include "evidence/mark_features.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"
#include "evidence/geodesic_distance.h"
#include "evidence/mark_measures.h"
#include "evidence/quantile.h"

namespace simplexseg {
namespace {

constexpr int kRounds = 3;

}  // namespace

MarkFeatures::MarkFeatures(const PriorInput& input, const Looks& looks, std::span<const float> walk,
                           const EvidenceSettings& settings, const RunJobs& run)
    : input_(input), looks_(looks) {
  view_.grid = input.grid;
  view_.known = input.known.data();
  view_.image = input.image.data();
  for (int s = 1; s < 3; ++s) view_.smoothed[s - 1] = input.features[s].data();
  view_.score = looks.score.data();
  view_.walk = walk.data();
  view_.from_inside = input.from_inside.data();
  view_.balls = input.balls.data();
  view_.noise = noise_of(input.inner_difference);
  view_.wall = 0;
  view_.reach_mm = static_cast<float>(input.reach_mm);
  view_.radius_mm = static_cast<float>(input.radius_mm);
  view_.least_mm = static_cast<float>(*std::min_element(input.spacing_mm.begin(), input.spacing_mm.end()));
  view_.marks = static_cast<int>(input.balls.size());
  view_.use_geodesic = settings.use_geodesic;
  view_.use_random_walk = settings.use_random_walk;
  measure_ways(settings, run);
  measure_inside();
  measure_wall();
  find_nearest(run);
}

void MarkFeatures::measure_ways(const EvidenceSettings& settings, const RunJobs& run) {
  const int n = static_cast<int>(input_.known.size());
  inside_.resize(n);
  outside_.resize(n);
  for (int v = 0; v < n; ++v) {
    inside_[v] = start_of_way(is_inside_start(input_.known[v]));
    outside_[v] = start_of_way(is_outside_start(input_.known[v], looks_.open[v] != 0));
  }
  edges_in_ = inside_;
  edges_out_ = outside_;
  const std::array to{&inside_, &outside_, &edges_in_, &edges_out_};
  const EdgeCost changes = cost_of_changes(settings), edges = cost_of_edges(view_.noise);
  run(static_cast<int>(to.size()), [&](int which) {
    lower_geodesic_distance(*to[which], input_.image, input_.grid, input_.spacing_mm, which < 2 ? changes : edges,
                            kRounds);
  });
  view_.inside = inside_.data();
  view_.outside = outside_.data();
  view_.edges_in = edges_in_.data();
  view_.edges_out = edges_out_.data();
}

void MarkFeatures::measure_inside() {
  std::array<std::vector<float>, 3> values;
  for (std::size_t l = 0; l < values.size(); ++l) {
    const std::span<const float> list = l == 0 ? input_.image : std::span<const float>(input_.features[l]);
    for (std::size_t v = 0; v < list.size(); ++v)
      if (input_.known[v] == Constraint::Inside) values[l].push_back(list[v]);
  }
  view_.strangeness = strangeness_among(values);
}

void MarkFeatures::measure_wall() {
  std::vector<float> shell;
  for (int v = 0; v < static_cast<int>(input_.known.size()); ++v)
    if (view_.is_in_shell(v)) shell.push_back(view_.strange(v));
  if (!shell.empty()) view_.wall = quantile(shell, 0.5);
}

void MarkFeatures::find_nearest(const RunJobs& run) {
  nearest_.assign(input_.known.size(), 0);
  from_outside_.assign(input_.known.size(), 1e12f);
  std::array<float, 3> mm;
  for (int a = 0; a < 3; ++a) mm[a] = static_cast<float>(input_.spacing_mm[a]);
  run(input_.grid.size[2], [&](int k) {
    for (int j = 0; j < input_.grid.size[1]; ++j) {
      for (int i = 0; i < input_.grid.size[0]; ++i) {
        const std::size_t v = static_cast<std::size_t>(k) * input_.grid.plane() + j * input_.grid.row() + i;
        float least = 1e12f;
        for (std::size_t b = 0; b < input_.balls.size(); ++b) {
          const MarkedBall& ball = input_.balls[b];
          const float square = square_to(ball, i, j, k, mm);
          if (!ball.inside)
            from_outside_[v] = smaller(square, from_outside_[v]);
          else if (square < least)
            least = square, nearest_[v] = static_cast<std::uint16_t>(b);
        }
      }
    }
  });
  view_.nearest = nearest_.data();
  view_.from_outside = from_outside_.data();
}

void MarkFeatures::fill(int first, int count, FeatureRows& to) const {
  for (int l = 0; l < count; ++l) view_.fill(first + l, [&to, l](int f, float value) { to[f][l] = value; });
}

}  // namespace simplexseg
