// SPDX-License-Identifier: Apache-2.0
#include "evidence/field_prior.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"
#include "core/vec3.h"
#include "evidence/find_value.h"
#include "evidence/mark_features.h"
#include "evidence/prior_network.h"
#include "evidence/update_features.h"

namespace simplexseg {
namespace {

constexpr double kLeastCut = 0.2;
constexpr std::size_t most_samples = 2000;  // of one kind: more teach the classifier nothing, and cost time

using Samples = std::vector<MarkClassifier::Sample>;

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
  for (const MarkClassifier::Sample& s : samples) sum += s.weight;
  return sum;
}

std::vector<float> score_of(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run) {
  std::vector<float> score(input.known.size());
  if (!settings.use_appearance) return score;
  const LookSamples samples = look_samples(input.known, settings);
  if (samples.inside.empty() || samples.outside.empty()) return score;
  MarkClassifier(input.features, samples.inside, samples.outside, {}, run).score(input.features, score, run);
  return score;
}

void move_to_best_cut(std::vector<std::uint8_t>& probability, std::span<const Constraint> known) {
  std::array<int, 256> count{};
  for (std::size_t v = 0; v < known.size(); ++v)
    if (const int p = counted_for_cut(known[v], probability[v]); p >= 0) ++count[p];
  const double raise = raise_to_best_cut(count);
  std::array<std::uint8_t, 256> moved;
  for (int p = 0; p < 256; ++p) moved[p] = moved_by(p, raise);
  for (std::uint8_t& p : probability) p = moved[p];
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
    for (MarkClassifier::Sample& s : outside) s.weight *= raise;
  }
  outside.insert(outside.end(), border.begin(), border.end());
  return {std::move(inside), std::move(outside)};
}

Looks looks_of(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run) {
  Looks looks{score_of(input, settings, run), std::vector<std::uint8_t>(input.known.size())};
  for (std::size_t v = 0; v < looks.open.size(); ++v)
    looks.open[v] = is_open(input.known[v], looks.score[v], settings.open_side);
  return looks;
}

std::vector<std::uint8_t> field_prior(const PriorInput& input, const Looks& looks, std::span<const float> walk,
                                      const EvidenceSettings& settings, const RunJobs& run) {
  SIMPLEXSEG_EXPECT(walk.size() == input.known.size());
  const int n = static_cast<int>(input.known.size());
  const PriorNetworks& networks = settings.networks ? *settings.networks : learned_networks();
  std::vector<std::uint8_t> target(n);
  {
    const MarkFeatures features(input, looks, walk, settings, run);
    networks.marks.evaluate([&](int first, int count, FeatureRows& to) { features.fill(first, count, to); }, target,
                            run);
  }
  if (input.fresh.empty() || !settings.memory) {
    if (settings.expected_dice_threshold) move_to_best_cut(target, input.known);
    return target;
  }
  const UpdateFeatures features(input, target, settings, run);
  std::vector<std::uint8_t> same_side(n);
  networks.update.evaluate([&](int first, int count, FeatureRows& to) { features.fill(first, count, to); }, same_side,
                           run);
  for_each_index(run, n, [view = features.view(), same = same_side.data(), to = target.data()](int v) {
    to[v] = view.with_memory(v, same[v]);
  });
  return target;
}

}  // namespace simplexseg
