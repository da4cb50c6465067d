// SPDX-License-Identifier: Apache-2.0
#include "evidence/field_prior.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"
#include "core/vec3.h"
#include "evidence/mark_features.h"
#include "evidence/prior_network.h"
#include "evidence/update_features.h"

namespace simplexseg {
namespace {

constexpr double kLeastCut = 0.2;
constexpr std::size_t most_samples = 2000;  // of one kind: more teach the classifier nothing, and cost time

using Samples = std::vector<MarkClassifier::Sample>;

/// Keeps at most so many, evenly, with the weight of all.
void thin(Samples& samples) {
  if (samples.size() <= most_samples) return;
  const float weight = static_cast<float>(samples.size()) / most_samples;
  for (std::size_t s = 0; s < most_samples; ++s)
    samples[s] = {samples[s * samples.size() / most_samples].voxel, weight};
  samples.resize(most_samples);
}

float total(const Samples& samples) {
  float sum = 0;
  for (const MarkClassifier::Sample& s : samples) sum += s.weight;
  return sum;
}

std::vector<float> score_of(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run) {
  std::vector<float> score(input.known.size());
  if (!settings.hear_looks) return score;
  Samples inside, outside, border;
  for (int v = 0; v < static_cast<int>(input.known.size()); ++v) {
    const Known known = input.known[v];
    if (known == Known::Inside) inside.push_back({v, 1});
    if (known == Known::Outside) outside.push_back({v, 1});
    if (known == Known::FarBorder || known == Known::VolumeEdge) border.push_back({v, 1});
  }
  for (Samples* samples : {&inside, &outside, &border}) thin(*samples);
  // A few dots beside thousands of voxels of the border would not be heard.
  const float dots = total(outside), far = total(border), share = static_cast<float>(settings.dots_share);
  if (dots > 0 && far > 0 && dots < share * (dots + far)) {
    const float raise = share >= 1 ? 1e6f : share / (1 - share) * far / dots;
    for (MarkClassifier::Sample& s : outside) s.weight *= raise;
  }
  outside.insert(outside.end(), border.begin(), border.end());
  if (inside.empty() || outside.empty()) return score;
  MarkClassifier(input.features, inside, outside, {}).score(input.features, score, run);
  return score;
}

/// Moves all so that the middle is where the Dice of what is above it is the largest to be expected, each voxel being
/// the object's with its probability: at half that Dice.
void move_to_best_cut(std::vector<std::uint8_t>& probability, std::span<const Known> known) {
  std::array<double, 256> count{};
  double all = 0;
  for (std::size_t v = 0; v < known.size(); ++v)
    if (known[v] == Known::Nothing) {
      ++count[probability[v]];
      all += probability[v] / 255.0;
    } else if (known[v] == Known::Inside) {
      ++count[255];
      ++all;
    }
  double taken = 0, right = 0, most = 0;
  for (int p = 255; p > 0; --p) {
    taken += count[p];
    right += count[p] * p / 255.0;
    if (taken > 0) most = std::max(most, 2 * right / (taken + all));
  }
  const double cut = std::clamp(most / 2, kLeastCut, 0.5), raise = (1 - cut) / cut;
  std::array<std::uint8_t, 256> moved;
  for (int p = 0; p < 256; ++p) moved[p] = static_cast<std::uint8_t>(255 * (p * raise / (p * raise + 255 - p)) + 0.5);
  for (std::uint8_t& p : probability) p = moved[p];
}

}  // namespace

Looks looks_of(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run) {
  Looks looks{score_of(input, settings, run), std::vector<std::uint8_t>(input.known.size())};
  for (std::size_t v = 0; v < looks.open.size(); ++v)
    looks.open[v] = input.known[v] == Known::FarBorder && looks.score[v] > settings.open_side;
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
    if (settings.best_cut) move_to_best_cut(target, input.known);
    return target;
  }
  const UpdateFeatures features(input, target, run);
  std::vector<std::uint8_t> same_side(n);
  networks.update.evaluate([&](int first, int count, FeatureRows& to) { features.fill(first, count, to); }, same_side,
                           run);
  const float share = static_cast<float>(settings.far_memory), near = static_cast<float>(settings.far_depths);
  for_each_index(run, n,
                 [=, &features, same = same_side.data(), before = input.before.data(), to = target.data()](int v) {
                   const float now = features.nearest_is_inside(v) ? same[v] : 255.0f - same[v];
                   const float old =
                       before[v] == 0 ? 0.0f : share * smaller(larger(features.depths_away(v) / near - 1, 0.0f), 1.0f);
                   to[v] = static_cast<std::uint8_t>(now + old * (before[v] - now) + 0.5f);
                 });
  return target;
}

}  // namespace simplexseg
