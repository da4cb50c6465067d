// SPDX-License-Identifier: Apache-2.0
#include "evidence/mark_features.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"
#include "evidence/geodesic_distance.h"
#include "evidence/quantile.h"

namespace simplexseg {
namespace {

constexpr int kRounds = 3, kMostSteps = 20;
constexpr float kUnreached = 1e4f, kEdgeLengthCost = 0.002f;
constexpr float kStrange = 3, kMostStrange = 6;             // deviations
constexpr float kShellFirst = 1.15f, kShellLast = 1.7f;     // reaches: where the wall is looked for
constexpr float kFarthestMark = 5;                          // reaches
constexpr float kLeastWalk = 0.003f;                        // and its rest: the most that the walk is believed
constexpr std::array kLeastDeviation{0.01f, 0.03f, 0.03f};  // of the image's range; of the smoothed ones' deviation

}  // namespace

MarkFeatures::MarkFeatures(const PriorInput& input, const Looks& looks, std::span<const float> walk,
                           const EvidenceSettings& settings, const RunJobs& run)
    : input_(input),
      looks_(looks),
      walk_(walk),
      hear_ways_(settings.hear_ways),
      hear_walk_(settings.hear_walk),
      noise_(input.inner_difference + 0.01f),
      reach_mm_(static_cast<float>(input.reach_mm)),
      least_mm_(static_cast<float>(*std::min_element(input.spacing_mm.begin(), input.spacing_mm.end()))) {
  measure_ways(settings, run);
  measure_inside();
  measure_wall();
  find_nearest(run);
}

void MarkFeatures::measure_ways(const EvidenceSettings& settings, const RunJobs& run) {
  const int n = static_cast<int>(input_.known.size());
  inside_.assign(n, kUnreached);
  outside_.assign(n, kUnreached);
  for (int v = 0; v < n; ++v) {
    if (input_.known[v] == Known::Inside)
      inside_[v] = 0;
    else if (input_.known[v] != Known::Nothing && !looks_.open[v])
      outside_[v] = 0;
  }
  edges_in_ = inside_;
  edges_out_ = outside_;
  const std::array to{&inside_, &outside_, &edges_in_, &edges_out_};
  const WayCost changes{static_cast<float>(settings.length_cost)}, edges{kEdgeLengthCost, 3 * noise_};
  run(static_cast<int>(to.size()), [&](int which) {
    lower_geodesic_distance(*to[which], input_.image, input_.grid, input_.spacing_mm, which < 2 ? changes : edges,
                            kRounds);
  });
}

void MarkFeatures::measure_inside() {
  std::vector<float> values;
  for (std::size_t l = 0; l < middle_.size(); ++l) {
    const std::span<const float> list = l == 0 ? input_.image : std::span<const float>(input_.features[l]);
    values.clear();
    for (std::size_t v = 0; v < list.size(); ++v)
      if (input_.known[v] == Known::Inside) values.push_back(list[v]);
    if (values.empty()) continue;  // later marks have taken all of them
    middle_[l] = quantile(values, 0.5);
    for (float& x : values) x = std::fabs(x - middle_[l]);
    per_deviation_[l] = 1 / (static_cast<float>(kDeviationsOfMedian) * quantile(values, 0.5) + kLeastDeviation[l]);
  }
}

void MarkFeatures::measure_wall() {
  std::vector<float> shell;
  const float low = kShellFirst * reach_mm_, high = kShellLast * reach_mm_;
  for (int v = 0; v < static_cast<int>(input_.known.size()); ++v)
    if (input_.from_inside[v] > low * low && input_.from_inside[v] < high * high && input_.known[v] != Known::NotFinite)
      shell.push_back(strange(v));
  if (!shell.empty()) wall_ = quantile(shell, 0.5);
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
          const float x = (static_cast<float>(i) - ball.index[0]) * mm[0],
                      y = (static_cast<float>(j) - ball.index[1]) * mm[1],
                      z = (static_cast<float>(k) - ball.index[2]) * mm[2], square = x * x + y * y + z * z;
          if (!ball.inside)
            from_outside_[v] = smaller(square, from_outside_[v]);
          else if (square < least)
            least = square, nearest_[v] = static_cast<std::uint16_t>(b);
        }
      }
    }
  });
}

float MarkFeatures::strange(int voxel) const {
  return smaller(std::fabs(input_.image[voxel] - middle_[0]) * per_deviation_[0], kMostStrange);
}

MarkFeatures::Line MarkFeatures::line_to(int voxel) const {
  const std::array<float, 3>& from = input_.balls[nearest_[voxel]].index;
  const std::array at{voxel % input_.grid.size[0], voxel / input_.grid.row() % input_.grid.size[1],
                      voxel / input_.grid.plane()};
  std::array<float, 3> way;
  float longest = 0;
  for (int a = 0; a < 3; ++a) {
    way[a] = static_cast<float>(at[a]) - from[a];
    longest = larger(std::fabs(way[a]), longest);
  }
  const int steps = std::clamp(static_cast<int>(longest + 0.5f), 1, kMostSteps);
  const float step = 1 / static_cast<float>(steps);
  Line line;
  for (int s = 1; s <= steps; ++s) {
    const float t = static_cast<float>(s) * step;
    int v = 0;
    for (int a = 0; a < 3; ++a)
      v +=
          input_.grid.stride(a) * std::clamp(static_cast<int>(from[a] + t * way[a] + 0.5f), 0, input_.grid.size[a] - 1);
    const float here = strange(v);
    line.most = larger(here, line.most);
    line.mean += step * here;
    if (line.first == 1 && here > kStrange) line.first = t - step;
  }
  return line;
}

void MarkFeatures::fill(int first, int count, FeatureRows& to) const {
  for (int l = 0; l < count; ++l) {
    const int v = first + l;
    const float in = inside_[v], out = outside_[v], w = smaller(larger(walk_[v], kLeastWalk), 1 - kLeastWalk);
    const float distance = std::sqrt(input_.from_inside[v]), reaches = distance / reach_mm_;
    const Line line = line_to(v);
    to[0][l] = looks_.score[v];
    to[1][l] = hear_ways_ ? (out - in) / (out + in + 1e-3f) : 0.0f;
    to[2][l] = hear_walk_ ? std::log(w / (1 - w)) : 0.0f;
    to[3][l] = std::log(reaches + 0.1f);
    to[4][l] = std::log(distance / input_.balls[nearest_[v]].radius_mm + 0.1f);
    to[5][l] = std::log(smaller(std::sqrt(from_outside_[v]) / reach_mm_, kFarthestMark) + 0.1f);
    to[6][l] = std::log(edges_in_[v] + 0.05f);
    to[7][l] = std::log(smaller(edges_out_[v], 100.0f) + 0.05f);
    to[8][l] = strange(v);
    for (int s = 1; s < 3; ++s)
      to[8 + s][l] = smaller(std::fabs(input_.features[s][v] - middle_[s]) * per_deviation_[s], kMostStrange);
    to[11][l] = line.most;
    to[12][l] = line.mean;
    to[13][l] = line.first;
    to[14][l] = std::log(line.first * reaches + 0.1f);
    to[15][l] = std::log(reach_mm_ / static_cast<float>(input_.radius_mm));
    to[16][l] = std::log(reach_mm_ / least_mm_);
    to[17][l] = std::log(noise_);
    to[18][l] = -std::log(per_deviation_[0]);
    to[19][l] = wall_;
    to[20][l] = std::log(static_cast<float>(input_.balls.size()));
  }
}

}  // namespace simplexseg
