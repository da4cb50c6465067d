// SPDX-License-Identifier: Apache-2.0
#include "evidence/evidence_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "evidence/brush_radius.h"
#include "evidence/conductances.h"
#include "evidence/evidence_box.h"
#include "evidence/field_prior.h"
#include "evidence/seed_reach.h"
#include "evidence/surface_layer.h"
#include "image/voxel_rows.h"

namespace simplexseg {
namespace {

constexpr int most_growths = 12;
constexpr double growing_tolerance = 0.1;  // of the field while the box still grows
constexpr float unreached_mm = 1e6f;
constexpr double leak_share = 0.05;
constexpr double unsaid_corrections = 4;  // that count as half of either kind, before marks say which way they go

}  // namespace

EvidenceField::EvidenceField(Volume volume, RunJobs run, EvidenceSettings settings)
    : volume_(std::move(volume)),
      run_(std::move(run)),
      settings_(settings),
      coarse_(volume_.geometry(), run_, settings_) {
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
  if (walker_ && box == box_ && reach_of_box_mm_ == reach_mm_) return;
  BoxImage image = cut_out(volume_, box, run_);
  coarse_.set_box(image, box.first, reach_mm_);
  reach_of_box_mm_ = reach_mm_;
  if (walker_ && box == box_) return;
  const VoxelBox old = box_;
  std::vector<float> field;
  if (walker_) field.assign(walker_->field().begin(), walker_->field().end());
  box_ = box;
  finite_ = image.finite;
  smoothed_ = image.value;
  image_ = std::move(image.value);
  smooth_by_least_spacing(smoothed_, image.grid, spacing_mm_, settings_.image_smoothing, run_);
  walker_ = std::make_unique<RandomWalker>(image.grid, spacing_mm_, run_);
  if (field.empty()) return;
  copy_into_outer(field.data(), old, walker_->field().data(), box);  // a box only grows
  if (before_.empty()) return;
  std::vector<std::uint8_t> before(box.voxel_count());
  copy_into_outer(before_.data(), old, before.data(), box);
  before_ = std::move(before);
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
  std::vector<int> corrections;
  for (const Mark& mark : marks) {
    const auto old = std::find(marks_.begin(), marks_.end(), mark);
    corrections.push_back(old == marks_.end() ? correction_of(mark) : corrections_[old - marks_.begin()]);
  }
  corrections_ = std::move(corrections);
  marks_.assign(marks.begin(), marks.end());
}

int EvidenceField::correction_of(const Mark& mark) const {
  if (before_.empty()) return 0;
  const double voxel = volume_.geometry().spacing_mm.minCoeff();
  if (depth_before_mm(mark.position_mm) > settings_.surface_layer * voxel) return 0;
  if (was_object(mark.position_mm)) return mark.kind == MarkKind::Inside ? 0 : -1;
  return mark.kind == MarkKind::Outside ? 0 : 1;
}

double EvidenceField::lean() const {
  double sum = 0, count = unsaid_corrections;
  for (const int correction : corrections_) sum += correction, count += std::abs(correction);
  return settings_.surface_lean * sum / count;
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
  double sum = 0;
  int wrong = 0;
  for (double t = 0.5; t <= 0.5 + 2 * mark.radius_mm / voxel; t += step_voxels)
    if (was_object(mark.position_mm + t * way) != inside) sum += t, ++wrong;
  if (wrong == 0) return std::nullopt;
  return mark.position_mm + sum / wrong * way;
}

bool EvidenceField::was_object(const Eigen::Vector3d& at_mm) const {
  const Eigen::Vector3d index = volume_.geometry().index_from_world() * at_mm;
  std::array<int, 3> p;
  for (int a = 0; a < 3; ++a)
    p[a] = std::clamp(static_cast<int>(std::lround(index[a])) - box_.first[a], 0, box_.size[a] - 1);
  return before_[box_.offset(p[0], p[1], p[2])] > kMiddleBefore;
}

double EvidenceField::depth_before_mm(const Eigen::Vector3d& at_mm) const {
  const bool in = was_object(at_mm);
  const std::vector<float> square = squared_distances(volume_.geometry(), box_, {&at_mm, 1}, run_);
  float least = unreached_mm * unreached_mm;
  for (std::size_t v = 0; v < before_.size(); ++v)
    if ((before_[v] > kMiddleBefore) != in) least = std::min(least, square[v]);
  return std::sqrt(least);
}

std::vector<NewDot> EvidenceField::new_dots() const {
  std::vector<NewDot> fresh;
  if (before_.empty()) return fresh;
  const auto add = [&](const Eigen::Vector3d& centre_mm, double radius_mm, bool inside) {
    fresh.push_back({centre_mm, radius_mm, inside, depth_before_mm(centre_mm)});
  };
  for (std::size_t m = fresh_; m < marks_.size(); ++m) {
    const Mark& mark = marks_[m];
    const std::size_t had = fresh.size();
    if (mark.kind == MarkKind::Boundary)
      for (const bool inside : {true, false})
        if (const auto middle = middle_of_wrong(mark, inside)) add(*middle, mark.radius_mm, inside);
    if (fresh.size() > had) continue;
    const Eigen::Vector3d step = dot_step(mark);
    if (mark.kind != MarkKind::Outside) add(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add(mark.position_mm + step, mark.radius_mm, false);
  }
  return fresh;
}

void EvidenceField::learn() {
  report_.beta = sharpness_of(inner_difference(walker_->grid(), spacing_mm_, smoothed_, known_), settings_);
  fresh_dots_ = new_dots();
  coarse_.learn(said());
  prior_.resize(known_.size());
  coarse_.interpolate(smoothed_, static_cast<float>(1 / std::sqrt(2 * report_.beta)), prior_);
}

void EvidenceField::solve(double tolerance) {
  const BoxGrid& grid = walker_->grid();
  const int n = grid.count();
  set_edges(*walker_, spacing_mm_, smoothed_, finite_, report_.beta, settings_.prior_pull, run_);
  std::vector<std::uint8_t> held(n);
  coarse_.mark_open(known_, held);
  for_each_index(run_, n, [known = known_.data(), field = walker_->field().data(), held = held.data()](int v) {
    held[v] = is_held(known[v]) && held[v] == 0;
    if (held[v]) field[v] = known[v] == Known::Inside;
  });
  const RandomWalker::Report solved = walker_->solve(prior_, held, tolerance, settings_.most_iterations);
  report_.iterations = solved.iterations;
  report_.error = solved.error;
  probability_.assign(walker_->field().begin(), walker_->field().end());
  // An object that the volume cuts goes on to the volume's side.
  for (int v = 0; v < n; ++v) {
    if (known_[v] != Known::VolumeEdge) continue;
    const std::array<int, 3> at{v % box_.size[0], v / box_.size[0] % box_.size[1], v / grid.plane()};
    int inner = v;
    for (int a = 0; a < 3; ++a) {
      if (box_.size[a] < 3) continue;
      if (at[a] == 0) inner += grid.stride(a);
      if (at[a] == box_.size[a] - 1) inner -= grid.stride(a);
    }
    probability_[v] = walker_->field()[inner];
  }
  smooth_by_least_spacing(probability_, grid, spacing_mm_, settings_.field_smoothing, run_);
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
    known_ = known_voxels(geometry, box, finite_, marks, others);
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
  report_.expected_dice = expected_dice();  // looks are surer than they are right
  settle_surface(probability_, object_, known_, image_, box_, spacing_mm_, lean(), settings_, run_);
  object_ = object_of_field(probability_, known_, box_);
  report_.leaks = object_.border_share >= leak_share;
}

double EvidenceField::expected_dice() const {
  double right = 0, all = 0;
  std::size_t taken = 0;
  for (std::size_t v = 0; v < probability_.size(); ++v) {
    all += probability_[v];
    if (!object_.voxels[v]) continue;
    right += probability_[v];
    ++taken;
  }
  return taken == 0 ? 0 : 2 * right / (static_cast<double>(taken) + all);
}

Mask EvidenceField::object() const { return mask_of(volume_.geometry(), box_, object_.voxels); }

double EvidenceField::brush_mm(MarkKind kind, const Eigen::Vector3d& position_mm) const {
  return brush_radius_mm(volume_.geometry(), box_, object_.voxels, known_, kind, position_mm, settings_);
}

std::size_t EvidenceField::bytes() const {
  const std::size_t bytes = finite_.size() + (image_.size() + smoothed_.size()) * 4 + known_.size() +
                            probability_.size() * 4 + object_.voxels.size() + before_.size() + prior_.size() +
                            coarse_.bytes();
  return bytes + (walker_ ? walker_->bytes() : 0);
}

}  // namespace simplexseg
