// SPDX-License-Identifier: Apache-2.0
#include "evidence/field_prior.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"
#include "evidence/geodesic_distance.h"
#include "evidence/prior_network.h"
#include "evidence/update_features.h"

namespace simplexseg {
namespace {

constexpr std::size_t most_samples = 2000;  // of one kind: more teach the classifier nothing, and cost time
constexpr int geodesic_rounds = 3;
constexpr float unreached = 1e4f;

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

std::vector<float> looks(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run) {
  std::vector<float> score(input.known.size());
  if (!(settings.classifier_share > 0)) return score;
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

}  // namespace

float inner_difference(const PriorInput& input) {
  const double least = *std::min_element(input.spacing_mm.begin(), input.spacing_mm.end());
  std::vector<float> differences;
  const int n = static_cast<int>(input.known.size());
  for (int a = 0; a < 3; ++a) {
    if (input.spacing_mm[a] >= 2 * least || input.grid.size[a] == 1) continue;
    const int stride = input.grid.stride(a);
    // The last voxel of a row and the first of the next are never both inside: they lie on two sides of the box.
    for (int v = 0; v + stride < n; ++v)
      if (input.known[v] == Known::Inside && input.known[v + stride] == Known::Inside)
        differences.push_back(std::fabs(input.image[v + stride] - input.image[v]));
  }
  if (differences.size() < 20) return 0;
  const auto at = differences.begin() + static_cast<std::ptrdiff_t>(0.75 * static_cast<double>(differences.size() - 1));
  std::nth_element(differences.begin(), at, differences.end());
  return *at;
}

FieldPrior field_prior(const PriorInput& input, const EvidenceSettings& settings, const RunJobs& run) {
  const int n = static_cast<int>(input.known.size());
  const std::vector<float> score = looks(input, settings, run);
  FieldPrior prior{std::vector<std::uint8_t>(n), std::vector<std::uint8_t>(n)};
  std::vector<float> inside(n, unreached), outside(n, unreached);
  for (int v = 0; v < n; ++v) {
    const Known known = input.known[v];
    prior.open[v] = known == Known::FarBorder && score[v] > settings.open_side;
    if (known == Known::Inside)
      inside[v] = 0;
    else if (known != Known::Nothing && !prior.open[v])
      outside[v] = 0;
  }
  if (settings.geodesic_share > 0) {
    run(2, [&](int which) {
      lower_geodesic_distance(which ? outside : inside, input.image, input.grid, input.spacing_mm,
                              {static_cast<float>(settings.length_cost)}, geodesic_rounds);
    });
  }
  const float slope = static_cast<float>(settings.prior_slope);
  const float c_share = static_cast<float>(settings.classifier_share),
              g_share = static_cast<float>(settings.geodesic_share),
              compactness = static_cast<float>(settings.compactness);
  const float per_radius = static_cast<float>(1 / input.reach_mm);
  for_each_index(run, n,
                 [=, in = inside.data(), out = outside.data(), c = score.data(), far = input.from_inside.data(),
                  to = prior.target.data()](int v) {
                   const float g = (out[v] - in[v]) / (out[v] + in[v] + 1e-3f);
                   const float s = larger(std::sqrt(far[v]) * per_radius - 1, 0.0f);
                   const float sum = c_share * c[v] + g_share * g - compactness * s;
                   to[v] = static_cast<std::uint8_t>(255 / (1 + std::exp(-slope * sum)) + 0.5f);
                 });
  if (input.fresh.empty() || !settings.memory) return prior;
  const UpdateFeatures features(input, prior.target, run);
  const PriorNetwork& network = settings.update ? *settings.update : learned_update();
  std::vector<std::uint8_t> same_side(n);
  network.evaluate([&](int first, int count, FeatureRows& to) { features.fill(first, count, to); }, same_side, run);
  for (int v = 0; v < n; ++v)
    prior.target[v] = features.nearest_is_inside(v) ? same_side[v] : static_cast<std::uint8_t>(255 - same_side[v]);
  return prior;
}

}  // namespace simplexseg
