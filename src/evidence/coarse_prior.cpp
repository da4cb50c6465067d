// SPDX-License-Identifier: Apache-2.0
#include "evidence/coarse_prior.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "evidence/conductances.h"
#include "evidence/mark_features.h"
#include "evidence/update_features.h"

namespace simplexseg {

CoarsePrior::CoarsePrior(RunJobs run, const EvidenceSettings& settings) : run_(std::move(run)), settings_(settings) {}

void CoarsePrior::set_box(const BoxImage& image, const VolumeGeometry& cells, const std::array<int, 3>& first,
                          double reach_mm) {
  coarse_ = coarse_image(cells, image, first, reach_mm, settings_, run_);
  walk_.assign(coarse_.blocks.coarse.count(), 0.0f);
}

std::vector<Constraint> CoarsePrior::known_blocks(const Prompts& said) const {
  std::vector<Constraint> known(coarse_.blocks.coarse.count(), Constraint::None);
  std::vector<std::uint16_t> outside(known.size()), not_finite(known.size()), all(known.size());
  coarse_.blocks.visit(run_, [&](int block, int voxel) {
    const Constraint at = said.known[voxel];
    ++all[block];
    outside[block] += at == Constraint::Outside;
    not_finite[block] += at == Constraint::NotFinite;
    known[block] = side_with(known[block], at);
  });
  for_each_index(run_, coarse_.blocks.coarse.count(),
                 [&](int b) { known[b] = known_of_block(outside[b], not_finite[b], all[b], known[b]); });
  paint_marks(coarse_.geometry, VoxelBox{{0, 0, 0}, coarse_.blocks.coarse.size}, said.marks, known);
  return known;
}

std::vector<std::uint8_t> CoarsePrior::mean_before(std::span<const std::uint8_t> before) const {
  if (before.empty()) return {};
  std::vector<int> sum(coarse_.blocks.coarse.count()), count(sum.size());
  coarse_.blocks.visit(run_, [&](int block, int voxel) {
    sum[block] += before[voxel];
    count[block] += before[voxel] != 0;
  });
  std::vector<std::uint8_t> mean(sum.size());
  for_each_index(run_, coarse_.blocks.coarse.count(),
                 [&](int b) { mean[b] = simplexseg::mean_before(sum[b], count[b]); });
  return mean;
}

template <class Use>
void CoarsePrior::with_input(const Prompts& said, Use&& use) const {
  const VoxelBox box{{0, 0, 0}, coarse_.blocks.coarse.size};
  std::vector<Eigen::Vector3d> inside;
  for (const Mark& mark : said.marks)
    if (mark.kind != MarkKind::Outside) inside.push_back(mark.position_mm);
  const std::vector<MarkedBall> balls = marked_balls(said.marks, coarse_.geometry);
  std::vector<FreshMark> fresh;
  for (const NewMarkBall& dot : said.fresh) {
    FreshMark& mark = fresh.emplace_back();
    mark.square_mm = squared_distances(coarse_.geometry, box, {&dot.centre_mm, 1}, run_);
    const int nearest =
        static_cast<int>(std::min_element(mark.square_mm.begin(), mark.square_mm.end()) - mark.square_mm.begin());
    mark.ball = {static_cast<float>(dot.radius_mm), coarse_.smoothed[nearest], static_cast<float>(dot.depth_mm),
                 nearest, dot.inside};
  }
  const std::vector<float> from_inside = squared_distances(coarse_.geometry, box, inside, run_);
  const std::vector<std::uint8_t> before = mean_before(said.before);
  use(PriorInput{coarse_.blocks.coarse, coarse_.spacing_mm, coarse_.smoothed, coarse_.features, known_, from_inside,
                 before, said.reach_mm, said.radius_mm,
                 inner_difference(coarse_.blocks.coarse, coarse_.spacing_mm, coarse_.smoothed, known_), balls, fresh});
}

void CoarsePrior::walk(const PriorInput& input) {
  const int n = coarse_.blocks.coarse.count();
  RandomWalker walker(coarse_.blocks.coarse, coarse_.spacing_mm, run_);
  std::ranges::copy(walk_, walker.field().begin());  // the last one is where this one starts
  std::vector<std::uint8_t> held(n), finite(n);
  for (int b = 0; b < n; ++b) {
    finite[b] = known_[b] != Constraint::NotFinite;
    held[b] = is_dirichlet(known_[b]) && !looks_.open[b];
    if (held[b]) walker.field()[b] = known_[b] == Constraint::Inside;
  }
  set_edges(walker, coarse_.spacing_mm, coarse_.smoothed, finite, sharpness_of(input.inner_difference, settings_), 0,
            run_);
  walker.solve(prior_, held, kWalkTolerance, settings_.most_iterations);
  std::ranges::copy(walker.field(), walk_.begin());
}

void CoarsePrior::learn(const Prompts& said, UpdateProgress* progress) {
  known_ = known_blocks(said);
  with_input(said, [&](const PriorInput& input) {
    looks_ = looks_of(input, settings_, run_);
    prior_.assign(known_.size(), 0);  // nothing draws the walk to it
    if (settings_.use_random_walk) walk(input);
    if (progress) progress->advance(FieldPhase::CoarsePrior);
    prior_ = field_prior(input, looks_, walk_, settings_, run_);
  });
}

void CoarsePrior::mark_open(std::span<const Constraint> known, std::span<std::uint8_t> open) const {
  coarse_.blocks.visit(run_, [&](int block, int voxel) {
    open[voxel] = known[voxel] == Constraint::FarBorder && looks_.open[block] != 0;
  });
}

template <class Features>
std::vector<std::vector<float>> CoarsePrior::listed(const Features& features) const {
  std::vector<std::vector<float>> all(Features::kCount, std::vector<float>(known_.size()));
  FeatureRows rows{};
  for (int first = 0; first < static_cast<int>(known_.size()); first += kLanes) {
    const int count = std::min(kLanes, static_cast<int>(known_.size()) - first);
    features.fill(first, count, rows);
    for (int f = 0; f < Features::kCount; ++f) std::copy_n(rows[f].data(), count, all[f].data() + first);
  }
  return all;
}

std::vector<std::vector<float>> CoarsePrior::mark_features(const Prompts& said) const {
  std::vector<std::vector<float>> all;
  with_input(said, [&](const PriorInput& input) { all = listed(MarkFeatures(input, looks_, walk_, settings_, run_)); });
  return all;
}

std::vector<std::vector<float>> CoarsePrior::update_features(const Prompts& said) const {
  std::vector<std::vector<float>> all;
  with_input(said, [&](const PriorInput& input) {
    if (input.fresh.empty()) return;
    EvidenceSettings settings = settings_;
    settings.memory = settings.expected_dice_threshold = false;
    const std::vector<std::uint8_t> anew = field_prior(input, looks_, walk_, settings, run_);
    const UpdateFeatures features(input, anew, settings, run_);
    all = listed(features);
    std::vector<float>& side = all.emplace_back(known_.size());
    for (int v = 0; v < static_cast<int>(known_.size()); ++v)
      side[v] = features.view().nearest_is_inside(v) ? 1.0f : 0.0f;
  });
  return all;
}

std::size_t CoarsePrior::bytes() const {
  std::size_t bytes = (coarse_.smoothed.size() + walk_.size() + looks_.score.size()) * 4 + known_.size() +
                      looks_.open.size() + prior_.size();
  for (const std::vector<float>& feature : coarse_.features) bytes += feature.size() * 4;
  return bytes;
}

}  // namespace simplexseg
