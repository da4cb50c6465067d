// SPDX-License-Identifier: Apache-2.0
#include "evidence/coarse_prior.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "evidence/conductances.h"
#include "evidence/mark_features.h"
#include "evidence/update_features.h"
#include "evidence/voxel_features.h"

namespace simplexseg {
namespace {

constexpr int kWidestBlock = 4, kLeastBlocks = 8;  // voxels of a block; blocks along an axis
constexpr double kWalkTolerance = 0.01;            // it is one voice of several

}  // namespace

CoarsePrior::CoarsePrior(const VolumeGeometry& geometry, RunJobs run, const EvidenceSettings& settings)
    : volume_(geometry), run_(std::move(run)), settings_(settings) {}

std::array<int, 3> CoarsePrior::width_for(const BoxGrid& grid, double reach_mm) const {
  const double least = volume_.spacing_mm.minCoeff();
  const int wide = std::clamp(static_cast<int>(reach_mm / least / settings_.least_reach), 1, kWidestBlock);
  std::array<int, 3> width;
  for (int a = 0; a < 3; ++a) {
    width[a] = std::max(1, static_cast<int>(std::lround(wide * least / volume_.spacing_mm[a])));
    width[a] = std::clamp(grid.size[a] / kLeastBlocks, 1, width[a]);
  }
  return width;
}

void CoarsePrior::set_box(const BoxImage& image, const std::array<int, 3>& first, double reach_mm) {
  blocks_ = VoxelBlocks(image.grid, width_for(image.grid, reach_mm));
  geometry_ = blocks_.geometry(volume_, first);
  for (int a = 0; a < 3; ++a) spacing_mm_[a] = geometry_.spacing_mm[a];
  smoothed_ = blocks_.mean(image.value, run_);
  features_ = voxel_features(smoothed_, blocks_.coarse, spacing_mm_, run_);
  smooth_by_least_spacing(smoothed_, blocks_.coarse, spacing_mm_, settings_.image_smoothing, run_);
  walker_ = std::make_unique<RandomWalker>(blocks_.coarse, spacing_mm_, run_);
}

std::vector<Known> CoarsePrior::known_blocks(const Said& said) const {
  std::vector<Known> known(blocks_.coarse.count(), Known::Nothing);
  std::vector<std::uint16_t> outside(known.size()), not_finite(known.size()), all(known.size());
  blocks_.visit(run_, [&](int block, int voxel) {
    const Known at = said.known[voxel];
    ++all[block];
    outside[block] += at == Known::Outside;
    not_finite[block] += at == Known::NotFinite;
    if (at == Known::FarBorder || (at == Known::VolumeEdge && known[block] == Known::Nothing)) known[block] = at;
  });
  for_each_index(run_, blocks_.coarse.count(), [&](int b) {
    if (2 * outside[b] >= all[b]) known[b] = Known::Outside;
    if (2 * not_finite[b] >= all[b]) known[b] = Known::NotFinite;
  });
  paint_marks(geometry_, VoxelBox{{0, 0, 0}, blocks_.coarse.size}, said.marks, known);
  return known;
}

std::vector<std::uint8_t> CoarsePrior::mean_before(std::span<const std::uint8_t> before) const {
  if (before.empty()) return {};
  std::vector<int> sum(blocks_.coarse.count()), count(sum.size());
  blocks_.visit(run_, [&](int block, int voxel) {
    sum[block] += before[voxel];
    count[block] += before[voxel] != 0;
  });
  std::vector<std::uint8_t> mean(sum.size());
  for_each_index(run_, blocks_.coarse.count(), [&](int b) {
    mean[b] = static_cast<std::uint8_t>(count[b] == 0 ? 0 : (sum[b] + count[b] / 2) / count[b]);
  });
  return mean;
}

template <class Use>
void CoarsePrior::with_input(const Said& said, Use&& use) const {
  const VoxelBox box{{0, 0, 0}, blocks_.coarse.size};
  const Eigen::Affine3d index = geometry_.index_from_world();
  std::vector<Eigen::Vector3d> inside;
  std::vector<MarkedBall> balls;
  const auto add = [&](const Eigen::Vector3d& mm, double radius_mm, bool in) {
    const Eigen::Vector3d at = index * mm;
    MarkedBall& ball = balls.emplace_back();
    for (int a = 0; a < 3; ++a) ball.index[a] = static_cast<float>(at[a]);
    ball.radius_mm = static_cast<float>(radius_mm);
    ball.inside = in;
  };
  for (const Mark& mark : said.marks) {
    const Eigen::Vector3d step = dot_step(mark);
    if (mark.kind != MarkKind::Outside) add(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add(mark.position_mm + step, mark.radius_mm, false);
    if (mark.kind != MarkKind::Outside) inside.push_back(mark.position_mm);
  }
  std::vector<FreshMark> fresh;
  for (const NewDot& dot : said.fresh) {
    FreshMark& mark = fresh.emplace_back();
    mark.square_mm = squared_distances(geometry_, box, {&dot.centre_mm, 1}, run_);
    mark.voxel =
        static_cast<int>(std::min_element(mark.square_mm.begin(), mark.square_mm.end()) - mark.square_mm.begin());
    mark.radius_mm = static_cast<float>(dot.radius_mm);
    mark.inside = dot.inside;
    mark.look = smoothed_[mark.voxel];
    mark.depth_mm = static_cast<float>(dot.depth_mm);
  }
  const std::vector<float> from_inside = squared_distances(geometry_, box, inside, run_);
  const std::vector<std::uint8_t> before = mean_before(said.before);
  use(PriorInput{blocks_.coarse, spacing_mm_, smoothed_, features_, known_, from_inside, before, said.reach_mm,
                 said.radius_mm, inner_difference(blocks_.coarse, spacing_mm_, smoothed_, known_), balls, fresh});
}

void CoarsePrior::walk(const PriorInput& input) {
  const int n = blocks_.coarse.count();
  std::vector<std::uint8_t> held(n), finite(n);
  for (int b = 0; b < n; ++b) {
    finite[b] = known_[b] != Known::NotFinite;
    held[b] = is_held(known_[b]) && !looks_.open[b];
    if (held[b]) walker_->field()[b] = known_[b] == Known::Inside;
  }
  set_edges(*walker_, spacing_mm_, smoothed_, finite, sharpness_of(input.inner_difference, settings_), 0, run_);
  walker_->solve(prior_, held, kWalkTolerance, settings_.most_iterations);
}

void CoarsePrior::learn(const Said& said) {
  known_ = known_blocks(said);
  with_input(said, [&](const PriorInput& input) {
    looks_ = looks_of(input, settings_, run_);
    prior_.assign(known_.size(), 0);  // nothing draws the walk to it
    if (settings_.hear_walk) walk(input);
    prior_ = field_prior(input, looks_, walker_->field(), settings_, run_);
  });
}

void CoarsePrior::mark_open(std::span<const Known> known, std::span<std::uint8_t> open) const {
  blocks_.visit(
      run_, [&](int block, int voxel) { open[voxel] = known[voxel] == Known::FarBorder && looks_.open[block] != 0; });
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

std::vector<std::vector<float>> CoarsePrior::mark_features(const Said& said) const {
  std::vector<std::vector<float>> all;
  with_input(said, [&](const PriorInput& input) {
    all = listed(MarkFeatures(input, looks_, walker_->field(), settings_, run_));
  });
  return all;
}

std::vector<std::vector<float>> CoarsePrior::update_features(const Said& said) const {
  std::vector<std::vector<float>> all;
  with_input(said, [&](const PriorInput& input) {
    if (input.fresh.empty()) return;
    EvidenceSettings settings = settings_;
    settings.memory = settings.best_cut = false;
    const std::vector<std::uint8_t> anew = field_prior(input, looks_, walker_->field(), settings, run_);
    const UpdateFeatures features(input, anew, run_);
    all = listed(features);
    std::vector<float>& side = all.emplace_back(known_.size());
    for (int v = 0; v < static_cast<int>(known_.size()); ++v) side[v] = features.nearest_is_inside(v) ? 1.0f : 0.0f;
  });
  return all;
}

std::size_t CoarsePrior::bytes() const {
  std::size_t bytes =
      smoothed_.size() * 4 + known_.size() + looks_.score.size() * 4 + looks_.open.size() + prior_.size();
  for (const std::vector<float>& feature : features_) bytes += feature.size() * 4;
  return bytes + (walker_ ? walker_->bytes() : 0);
}

}  // namespace simplexseg
