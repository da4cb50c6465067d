// SPDX-License-Identifier: Apache-2.0
#include "field/field_prior.h"

#include <algorithm>
#include <cmath>

#include "field/find_value.h"

namespace simplexseg {
namespace {

constexpr double kLeastThreshold = 0.2;
constexpr std::size_t kMostSamples = 2000;  // of one kind; more do not change the classifier

using Samples = std::vector<ClassifierSample>;

/// Every n-th of these voxels, at most kMostSamples, with equal weights that sum to the number of voxels.
Samples thinned(std::span<const int> voxels) {
  Samples samples(std::min(voxels.size(), kMostSamples));
  const std::size_t count = samples.size();
  const float weight = static_cast<float>(voxels.size()) / static_cast<float>(count);
  for (std::size_t s = 0; s < count; ++s) samples[s] = {voxels[s * voxels.size() / count], weight};
  return samples;
}

float total(const Samples& samples) {
  float sum = 0;
  for (const ClassifierSample& s : samples) sum += s.weight;
  return sum;
}

}  // namespace

double expected_dice_odds_factor(std::span<const int, 256> count) {
  double all = 0;
  for (int p = 0; p < 256; ++p) all += count[p] * p / 255.0;
  double above = 0, overlap = 0, best = 0;
  for (int p = 255; p > 0; --p) {
    above += count[p];
    overlap += count[p] * p / 255.0;
    if (above > 0) best = std::max(best, 2 * overlap / (above + all));
  }
  const double threshold = std::clamp(best / 2, kLeastThreshold, 0.5);
  return (1 - threshold) / threshold;
}

std::vector<MarkedBall> marked_balls(std::span<const Mark> marks, const VolumeGeometry& geometry) {
  const Eigen::Affine3d index = geometry.index_from_world();
  std::vector<MarkedBall> balls;
  const auto add = [&](const Eigen::Vector3d& mm, double radius_mm, bool in) {
    const Eigen::Vector3d at = index * mm;
    MarkedBall& ball = balls.emplace_back();
    for (int a = 0; a < 3; ++a) ball.index[a] = static_cast<float>(at[a]);
    ball.radius_mm = static_cast<float>(radius_mm);
    ball.inside = in;
  };
  for (const Mark& mark : marks) {
    const Eigen::Vector3d step = ball_offset(mark);
    if (mark.kind != MarkKind::Outside) add(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add(mark.position_mm + step, mark.radius_mm, false);
  }
  return balls;
}

AppearanceSamples appearance_samples(std::span<const Constraint> constraints, const EvidenceSettings& settings) {
  const int n = static_cast<int>(constraints.size());
  std::vector<int> in, out, side;
  const auto next = [&](int from) { return find_other(constraints, Constraint::None, from, n); };
  for (int v = next(0); v < n; v = next(v + 1)) {
    if (constraints[v] == Constraint::Inside) in.push_back(v);
    if (constraints[v] == Constraint::Outside) out.push_back(v);
    if (constraints[v] == Constraint::FarBorder || constraints[v] == Constraint::VolumeEdge) side.push_back(v);
  }
  Samples inside = thinned(in), outside = thinned(out);
  const Samples border = thinned(side);
  // Outside marks have a least share, since the sides of the box have many more voxels.
  const float marked = total(outside), far = total(border), share = static_cast<float>(settings.outside_marks_share);
  if (marked > 0 && far > 0 && marked < share * (marked + far)) {
    const float raise = share >= 1 ? 1e6f : share / (1 - share) * far / marked;
    for (ClassifierSample& s : outside) s.weight *= raise;
  }
  outside.insert(outside.end(), border.begin(), border.end());
  return {std::move(inside), std::move(outside)};
}

}  // namespace simplexseg
