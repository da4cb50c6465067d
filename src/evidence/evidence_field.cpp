// SPDX-License-Identifier: Apache-2.0
#include "evidence/evidence_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "evidence/brush_radius.h"
#include "evidence/evidence_box.h"
#include "evidence/field_prior.h"
#include "evidence/mark_features.h"
#include "evidence/seed_reach.h"
#include "evidence/update_features.h"
#include "evidence/voxel_features.h"

namespace simplexseg {
namespace {

constexpr int most_growths = 12;
constexpr double growing_tolerance = 0.1;  // of the field while the box still grows
constexpr double walk_tolerance = 0.05;    // of the walk of the marks alone, which is one voice of several
constexpr float unreached_mm = 1e6f;
constexpr double leak_share = 0.05;
constexpr float least_conductance = 1e-5f;  // keeps every finite voxel connected

std::array<double, 3> of_least_spacing(double voxels, const std::array<double, 3>& spacing_mm) {
  const double mm = voxels * *std::min_element(spacing_mm.begin(), spacing_mm.end());
  return {mm / spacing_mm[0], mm / spacing_mm[1], mm / spacing_mm[2]};
}

/// Copies the values of a box into those of one that it lies in.
template <class T>
void copy_box(const T* from, const VoxelBox& inner, T* to, const VoxelBox& outer) {
  for (int k = 0; k < inner.size[2]; ++k)
    for (int j = 0; j < inner.size[1]; ++j)
      std::copy_n(from + inner.offset(0, j, k), inner.size[0],
                  to + outer.offset(inner.first[0] - outer.first[0], j + inner.first[1] - outer.first[1],
                                    k + inner.first[2] - outer.first[2]));
}

}  // namespace

EvidenceField::EvidenceField(Volume volume, RunJobs run, EvidenceSettings settings)
    : volume_(std::move(volume)), run_(std::move(run)), settings_(settings) {
  if (volume_.empty()) throw Error("the evidence field", "there is no volume", "open a volume first");
  for (int a = 0; a < 3; ++a) spacing_mm_[a] = volume_.geometry().spacing_mm[a];
}

void EvidenceField::check(std::span<const Mark> marks, const Mask* others) const {
  bool inside = false;
  for (std::size_t m = 0; m < marks.size(); ++m) {
    const Mark& mark = marks[m];
    const std::string name = "mark " + std::to_string(m + 1);
    if (!(mark.radius_mm > 0) || !std::isfinite(mark.radius_mm))
      throw Error(name, "its radius is not a length above 0", "give it one in mm");
    if (!mark.position_mm.allFinite() || !volume_.geometry().contains(mark.position_mm))
      throw Error(name, "it lies outside of the volume", "move it into the image");
    if (mark.kind == MarkKind::Boundary && !(mark.outward.norm() > 0 && mark.outward.allFinite()))
      throw Error(name, "a boundary mark has no direction", "say which way is out of the object");
    inside |= mark.kind != MarkKind::Outside;
  }
  if (!inside) throw Error("the marks", "none says what is inside", "put a seed or an inside point into the object");
  if (others &&
      (others->geometry.size != volume_.geometry().size || others->voxels.size() != volume_.geometry().voxel_count()))
    throw Error("the other objects", "they are not on the grid of the volume", "resample them onto it");
}

void EvidenceField::set_box(const VoxelBox& box) {
  if (walker_ && box.first == box_.first && box.size == box_.size) return;
  const VoxelBox old = box_;
  std::vector<float> field;
  if (walker_) field.assign(walker_->field().begin(), walker_->field().end());
  box_ = box;
  image_ = cut_out(volume_, box, run_);
  smoothed_ = image_.value;
  smooth(smoothed_, image_.grid, of_least_spacing(settings_.image_smoothing, spacing_mm_), run_);
  features_ = voxel_features(image_, spacing_mm_, run_);
  walker_ = std::make_unique<RandomWalker>(image_.grid, spacing_mm_, run_);
  const std::vector<float> walk = std::exchange(walk_, std::vector<float>(box.voxel_count()));
  if (field.empty()) return;
  copy_box(field.data(), old, walker_->field().data(), box);  // a box only grows
  copy_box(walk.data(), old, walk_.data(), box);
  if (before_.empty()) return;
  std::vector<std::uint8_t> before(box.voxel_count());
  copy_box(before_.data(), old, before.data(), box);
  before_ = std::move(before);
}

void EvidenceField::set_conductances(double beta) {
  const double least = *std::min_element(spacing_mm_.begin(), spacing_mm_.end());
  for (int axis = 0; axis < 3; ++axis) {
    const float scale = static_cast<float>((least / spacing_mm_[axis]) * (least / spacing_mm_[axis]));
    const int stride = image_.grid.stride(axis);
    for_each_index(run_, image_.grid.count() - stride,
                   [scale, stride, fall = static_cast<float>(-beta), image = smoothed_.data(),
                    finite = image_.finite.data(), weight = walker_->weights(axis).data()](int v) {
                     const float d = image[v + stride] - image[v];
                     const float w = scale * (std::exp(fall * d * d) + least_conductance);
                     weight[v] = finite[v] && finite[v + stride] ? w : 0.0f;
                   });
  }
}

void EvidenceField::remember(std::span<const Mark> marks) {
  const auto same = static_cast<std::size_t>(
      std::mismatch(marks_.begin(), marks_.end(), marks.begin(), marks.end()).first - marks_.begin());
  if (same == marks_.size() && marks.size() > same) {
    before_.resize(probability_.size());
    for (std::size_t v = 0; v < before_.size(); ++v)
      before_[v] = static_cast<std::uint8_t>(1.5f + 254 * probability_[v]);
    fresh_ = same;
  } else if (same < fresh_) {
    before_.clear();
    fresh_ = same;
  }
  marks_.assign(marks.begin(), marks.end());
}

void EvidenceField::measure_reach(std::span<const Mark> marks) {
  Mark largest;
  for (const Mark& mark : marks)
    if (mark.kind != MarkKind::Outside && mark.radius_mm > largest.radius_mm) largest = mark;
  if (largest == largest_) return;
  largest_ = largest;
  reach_mm_ = largest.kind == MarkKind::Inside ? seed_reach_mm(volume_, largest.position_mm, largest.radius_mm)
                                               : largest.radius_mm;
}

std::optional<Eigen::Vector3d> EvidenceField::middle_of_wrong(const Mark& mark, bool inside) const {
  constexpr double step_voxels = 0.25;
  const double voxel = volume_.geometry().spacing_mm.minCoeff();
  const Eigen::Vector3d way = (inside ? -voxel : voxel) * mark.outward.normalized();
  const Eigen::Affine3d index = volume_.geometry().index_from_world();
  double sum = 0;
  int wrong = 0;
  for (double t = 0.5; t <= 0.5 + 2 * mark.radius_mm / voxel; t += step_voxels) {
    const Eigen::Vector3d at = index * (mark.position_mm + t * way);
    std::array<int, 3> p;
    for (int a = 0; a < 3; ++a)
      p[a] = std::clamp(static_cast<int>(std::lround(at[a])) - box_.first[a], 0, box_.size[a] - 1);
    const std::size_t v = (static_cast<std::size_t>(p[2]) * box_.size[1] + p[1]) * box_.size[0] + p[0];
    if ((before_[v] > kMiddleBefore) != inside) sum += t, ++wrong;
  }
  if (wrong == 0) return std::nullopt;
  return mark.position_mm + sum / wrong * way;
}

std::vector<FreshMark> EvidenceField::fresh_marks() const {
  std::vector<FreshMark> fresh;
  if (before_.empty()) return fresh;
  const auto add = [&](const Eigen::Vector3d& centre_mm, double radius_mm, bool inside) {
    FreshMark& mark = fresh.emplace_back();
    mark.square_mm = squared_distances(volume_.geometry(), box_, {&centre_mm, 1}, run_);
    mark.voxel =
        static_cast<int>(std::min_element(mark.square_mm.begin(), mark.square_mm.end()) - mark.square_mm.begin());
    mark.radius_mm = static_cast<float>(radius_mm);
    mark.inside = inside;
    mark.look = smoothed_[mark.voxel];
    const bool in = before_[mark.voxel] > kMiddleBefore;
    float square = unreached_mm * unreached_mm;
    for (std::size_t v = 0; v < before_.size(); ++v)
      if ((before_[v] > kMiddleBefore) != in) square = std::min(square, mark.square_mm[v]);
    mark.depth_mm = std::sqrt(square);
  };
  for (std::size_t m = fresh_; m < marks_.size(); ++m) {
    const Mark& mark = marks_[m];
    const std::size_t had = fresh.size();
    if (mark.kind == MarkKind::Boundary)
      for (const bool inside : {true, false})
        if (const auto middle = middle_of_wrong(mark, inside)) add(*middle, mark.radius_mm, inside);
    if (fresh.size() > had) continue;
    const Eigen::Vector3d step = dot_step(mark, volume_.geometry());
    if (mark.kind != MarkKind::Outside) add(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add(mark.position_mm + step, mark.radius_mm, false);
  }
  return fresh;
}

template <class Use>
void EvidenceField::with_prior_input(Use&& use) const {
  std::vector<Eigen::Vector3d> inside;
  std::vector<MarkedBall> balls;
  const auto add = [&](const Eigen::Vector3d& mm, double radius_mm, bool in) {
    const Eigen::Vector3d index = volume_.geometry().index_from_world() * mm;
    MarkedBall& ball = balls.emplace_back();
    for (int a = 0; a < 3; ++a) ball.index[a] = static_cast<float>(index[a] - box_.first[a]);
    ball.radius_mm = static_cast<float>(radius_mm);
    ball.inside = in;
  };
  for (const Mark& mark : marks_) {
    const Eigen::Vector3d step = dot_step(mark, volume_.geometry());
    if (mark.kind != MarkKind::Outside) add(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add(mark.position_mm + step, mark.radius_mm, false);
    if (mark.kind != MarkKind::Outside) inside.push_back(mark.position_mm);
  }
  const std::vector<float> from_inside = squared_distances(volume_.geometry(), box_, inside, run_);
  const std::vector<FreshMark> fresh = fresh_marks();
  use(PriorInput{image_.grid, spacing_mm_, smoothed_, features_, known_, from_inside, before_, reach_mm_,
                 largest_.radius_mm, balls, fresh});
}

void EvidenceField::learn() {
  with_prior_input([&](const PriorInput& input) {
    report_.beta = settings_.beta;
    if (settings_.sharpness > 0) {
      const double edge = settings_.sharpness * inner_difference(input);
      report_.beta = std::clamp(1 / (2 * edge * edge), settings_.least_beta, settings_.largest_beta);
    }
    looks_ = looks_of(input, settings_, run_);
    walk();
    prior_ = field_prior(input, looks_, walk_, settings_, run_);
  });
}

template <class Features>
std::vector<std::vector<float>> EvidenceField::listed(const Features& features) const {
  std::vector<std::vector<float>> all(Features::kCount, std::vector<float>(known_.size()));
  FeatureRows rows{};
  for (int first = 0; first < static_cast<int>(known_.size()); first += kLanes) {
    const int count = std::min(kLanes, static_cast<int>(known_.size()) - first);
    features.fill(first, count, rows);
    for (int f = 0; f < Features::kCount; ++f) std::copy_n(rows[f].data(), count, all[f].data() + first);
  }
  return all;
}

std::vector<std::vector<float>> EvidenceField::mark_features() const {
  std::vector<std::vector<float>> all;
  with_prior_input([&](const PriorInput& input) { all = listed(MarkFeatures(input, looks_, walk_, settings_, run_)); });
  return all;
}

std::vector<std::vector<float>> EvidenceField::update_features() const {
  std::vector<std::vector<float>> all;
  with_prior_input([&](const PriorInput& input) {
    if (input.fresh.empty()) return;
    EvidenceSettings settings = settings_;
    settings.memory = false;
    const std::vector<std::uint8_t> anew = field_prior(input, looks_, walk_, settings, run_);
    const UpdateFeatures features(input, anew, run_);
    all = listed(features);
    std::vector<float>& side = all.emplace_back(known_.size());
    for (int v = 0; v < static_cast<int>(known_.size()); ++v) side[v] = features.nearest_is_inside(v) ? 1.0f : 0.0f;
  });
  return all;
}

RandomWalker::Report EvidenceField::run_walker(double pull, double tolerance) {
  const int n = image_.grid.count();
  set_conductances(report_.beta);
  std::vector<std::uint8_t> held(n);
  for_each_index(
      run_, n,
      [known = known_.data(), open = looks_.open.data(), field = walker_->field().data(), held = held.data()](int v) {
        held[v] = is_held(known[v]) && !open[v];
        if (held[v]) field[v] = known[v] == Known::Inside;
      });
  // In proportion to the mean conductance: on an edge, which conducts little, the neighbours still say more than the
  // prior, which knows nothing of what lies half on either side.
  for_each_index(run_, n,
                 [pull = walker_->pull().data(), wx = walker_->weights(0).data(), row = box_.size[0],
                  wy = walker_->weights(1).data(), plane = image_.grid.plane(), wz = walker_->weights(2).data(),
                  gamma = static_cast<float>(pull / 6)](int v) {
                   pull[v] = gamma * (wx[v] + wx[v - 1] + wy[v] + wy[v - row] + wz[v] + wz[v - plane]);
                 });
  return walker_->solve(prior_, held, tolerance, settings_.most_iterations);
}

void EvidenceField::walk() {
  if (!settings_.hear_walk) return;
  const auto exchange = [&] { std::swap_ranges(walk_.begin(), walk_.end(), walker_->field().begin()); };
  exchange();                      // each goes on from its own field before
  prior_.assign(walk_.size(), 0);  // not heard: nothing draws to it
  run_walker(0, walk_tolerance);
  exchange();
}

void EvidenceField::solve(double tolerance) {
  const int n = image_.grid.count();
  const RandomWalker::Report solved = run_walker(settings_.prior_pull, tolerance);
  report_.iterations = solved.iterations;
  report_.error = solved.error;
  probability_.assign(walker_->field().begin(), walker_->field().end());
  // An object that the volume cuts goes on to the volume's side.
  for (int v = 0; v < n; ++v) {
    if (known_[v] != Known::VolumeEdge) continue;
    const std::array<int, 3> at{v % box_.size[0], v / box_.size[0] % box_.size[1], v / image_.grid.plane()};
    int inner = v;
    for (int a = 0; a < 3; ++a) {
      if (box_.size[a] < 3) continue;
      if (at[a] == 0) inner += image_.grid.stride(a);
      if (at[a] == box_.size[a] - 1) inner -= image_.grid.stride(a);
    }
    probability_[v] = walker_->field()[inner];
  }
  smooth(probability_, image_.grid, of_least_spacing(settings_.field_smoothing, spacing_mm_), run_);
  for (int v = 0; v < n; ++v)  // smoothing must not take back what was said
    if (known_[v] == Known::Inside || known_[v] == Known::Outside) probability_[v] = known_[v] == Known::Inside;
  object_ = object_of_field(probability_, known_, box_);
}

void EvidenceField::update(std::span<const Mark> marks, const Mask* others) {
  check(marks, others);
  const VolumeGeometry& geometry = volume_.geometry();
  measure_reach(marks);
  VoxelBox box = box_around(box_, box_around_marks(marks, geometry, settings_.margin_share, settings_.least_margin));
  report_ = {};
  remember(marks);
  const auto solve_in_box = [&] {
    set_box(box);
    known_ = known_voxels(geometry, box, image_.finite, marks, others);
    learn();
    solve(std::max(growing_tolerance, settings_.tolerance));
  };
  // Rough fields let the box grow; once it no longer does the field is solved to the end, which may show it more.
  const auto grows = [&] {
    if (object_.around.voxel_count() == 0 || report_.growths == most_growths) return false;
    const VoxelBox grown = grow_around(box, object_.around, geometry);
    if (grown.first == box.first && grown.size == box.size) return false;
    box = grown;
    ++report_.growths;
    return true;
  };
  do {
    do solve_in_box();
    while (grows());
    if (settings_.tolerance < growing_tolerance) solve(settings_.tolerance);
  } while (grows());
  report_.leaks = object_.border_share >= leak_share;
}

Mask EvidenceField::object() const { return mask_of(volume_.geometry(), box_, object_.voxels); }

double EvidenceField::brush_mm(MarkKind kind, const Eigen::Vector3d& position_mm) const {
  return brush_radius_mm(volume_.geometry(), box_, object_.voxels, known_, kind, position_mm, settings_);
}

std::size_t EvidenceField::bytes() const {
  std::size_t bytes = image_.value.size() * 4 + image_.finite.size() + smoothed_.size() * 4 + known_.size() +
                      probability_.size() * 4 + object_.voxels.size() + before_.size() + prior_.size() +
                      looks_.score.size() * 4 + looks_.open.size() + walk_.size() * 4;
  for (const std::vector<float>& feature : features_) bytes += feature.size() * 4;
  return bytes + (walker_ ? walker_->bytes() : 0);
}

}  // namespace simplexseg
