// SPDX-License-Identifier: Apache-2.0
#include "field/field_prior.h"

#include <algorithm>
#include <cmath>

#include "field/find_value.h"

namespace simplexseg {
namespace {

constexpr double kLeastCut = 0.2;
constexpr std::size_t most_samples = 2000;  // of one kind: more teach the classifier nothing, and cost time

using Samples = std::vector<ClassifierSample>;

/// At most so many of these voxels, evenly, with the weight of all.
Samples thinned(std::span<const int> voxels) {
  Samples samples(std::min(voxels.size(), most_samples));
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

double raise_to_best_cut(std::span<const int, 256> count) {
  double all = 0;
  for (int p = 0; p < 256; ++p) all += count[p] * p / 255.0;
  double taken = 0, right = 0, most = 0;
  for (int p = 255; p > 0; --p) {
    taken += count[p];
    right += count[p] * p / 255.0;
    if (taken > 0) most = std::max(most, 2 * right / (taken + all));
  }
  const double cut = std::clamp(most / 2, kLeastCut, 0.5);
  return (1 - cut) / cut;
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

LookSamples look_samples(std::span<const Constraint> known, const EvidenceSettings& settings) {
  const int n = static_cast<int>(known.size());
  std::vector<int> in, out, side;
  for (int v = find_other(known, Constraint::None, 0, n); v < n; v = find_other(known, Constraint::None, v + 1, n)) {
    if (known[v] == Constraint::Inside) in.push_back(v);
    if (known[v] == Constraint::Outside) out.push_back(v);
    if (known[v] == Constraint::FarBorder || known[v] == Constraint::VolumeEdge) side.push_back(v);
  }
  Samples inside = thinned(in), outside = thinned(out);
  const Samples border = thinned(side);
  // A few dots beside thousands of voxels of the border would not be heard.
  const float dots = total(outside), far = total(border), share = static_cast<float>(settings.outside_marks_share);
  if (dots > 0 && far > 0 && dots < share * (dots + far)) {
    const float raise = share >= 1 ? 1e6f : share / (1 - share) * far / dots;
    for (ClassifierSample& s : outside) s.weight *= raise;
  }
  outside.insert(outside.end(), border.begin(), border.end());
  return {std::move(inside), std::move(outside)};
}

}  // namespace simplexseg
