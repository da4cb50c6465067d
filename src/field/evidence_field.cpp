// SPDX-License-Identifier: Apache-2.0
#include "field/evidence_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "core/expect.h"
#include "field/brush_radius.h"
#include "field/evidence_box.h"
#include "field/seed_scale.h"

namespace simplexseg {
namespace {

constexpr int most_growths = 12;
constexpr double growing_tolerance = 0.1;  // of the field while the box still grows
constexpr double leak_share = 0.05;
constexpr double kLeastFill = 0.2;        // part of its bounding box that a spreading object fills; thin ones fill less
constexpr int kMostCutSides = 3;          // of a box, by which an object can be cut at a corner
constexpr double unsaid_corrections = 4;  // that count as half of either kind, before marks say which way they go
constexpr double unsaid_marks = 10;       // by which where the surface was is half believed: it is rough at first

/// Returns true when the object spreads: it is near a side of the box beyond which the volume continues, or near more
/// of the volume's own sides than an object in a corner of the volume. `near_mm`: largest distance from a side.
bool reaches_sides(const VoxelBox& object, const VoxelBox& box, const VolumeGeometry& geometry, double near_mm) {
  int own_sides = 0;
  for (int a = 0; a < 3; ++a) {
    const int end = box.first[a] + box.size[a];
    const double below_mm = (object.first[a] - box.first[a]) * geometry.spacing_mm[a];
    const double above_mm = (end - object.first[a] - object.size[a]) * geometry.spacing_mm[a];
    if (below_mm <= near_mm) {
      if (box.first[a] > 0) return true;
      ++own_sides;
    }
    if (above_mm <= near_mm) {
      if (end < geometry.size[a]) return true;
      ++own_sides;
    }
  }
  return own_sides > kMostCutSides;
}

}  // namespace

EvidenceField::EvidenceField(Volume volume, const RunJobs& run, const EvidenceSettings& settings,
                             const MakeFieldSolver& make)
    : volume_(std::make_unique<Volume>(std::move(volume))), settings_(settings) {
  if (volume_->empty()) throw Error("the segmentation field", "no image is open", "open an image first");
  voxels_ = make(*volume_, run, settings_);
  cells_ = volume_->geometry();
}

void EvidenceField::set_region(const VoxelBox& voxels) {
  const VolumeGeometry& volume = volume_->geometry();
  region_ = voxels;
  cell_ = cell_size_for(voxels, volume, reach_mm_, settings_);
  cells_ = cell_geometry(volume, cell_);
  box_ = cells_around(voxels, cell_, volume.size);
}

void EvidenceField::check(std::span<const Mark> marks) const {
  bool inside = false;
  for (std::size_t m = 0; m < marks.size(); ++m) {
    const Mark& mark = marks[m];
    const std::string name = "mark " + std::to_string(m + 1);
    if (!(mark.radius_mm > 0) || !std::isfinite(mark.radius_mm))
      throw Error(name, "its radius is not above 0", "give it a radius in mm");
    if (!mark.position_mm.allFinite() || !volume_->geometry().contains(mark.position_mm))
      throw Error(name, "it lies outside the image", "move it into the image");
    if (mark.kind == MarkKind::Boundary && !(mark.outward.norm() > 0 && mark.outward.allFinite()))
      throw Error(name, "a boundary mark has no direction", "give it a direction out of the object");
    inside |= mark.kind != MarkKind::Outside;
  }
  if (!inside) throw Error("the marks", "none lies inside the object", "place a seed or an inside mark in the object");
}

void EvidenceField::remember(std::span<const Mark> marks) {
  const auto same = static_cast<std::size_t>(
      std::mismatch(marks_.begin(), marks_.end(), marks.begin(), marks.end()).first - marks_.begin());
  if (same == marks_.size() && marks.size() > same) {
    voxels_->keep_before();
    fresh_ = same;
  } else if (same < fresh_) {
    voxels_->forget_before();
    fresh_ = same;
  }
  std::vector<Correction> corrections;
  for (const Mark& mark : marks) {
    const auto old = std::find(marks_.begin(), marks_.end(), mark);
    corrections.push_back(old == marks_.end() ? Correction{} : corrections_[old - marks_.begin()]);
  }
  corrections_ = std::move(corrections);
  marks_.assign(marks.begin(), marks.end());
}

void EvidenceField::look_back() {
  before_.clear();
  if (!voxels_->has_before()) return;
  std::vector<Eigen::Vector3d> places;
  for (std::size_t m = fresh_; m < marks_.size(); ++m) places.push_back(marks_[m].position_mm);
  before_ = voxels_->before(places);
  for (std::size_t m = fresh_; m < marks_.size(); ++m) corrections_[m] = correction_of(marks_[m], before_[m - fresh_]);
}

EvidenceField::Correction EvidenceField::correction_of(const Mark& mark, const FieldSolver::Before& before) const {
  const bool was = before.object;
  if (mark.kind == (was ? MarkKind::Inside : MarkKind::Outside)) return {};
  const double voxel = cells_.spacing_mm.minCoeff(), depth = before.depth_mm;
  const bool boundary = mark.kind == MarkKind::Boundary;
  // A dot is in the middle of what was wrong, a boundary mark at its end.
  if (depth > (boundary ? 2 : 1) * settings_.surface_layer * voxel) return {0, 0, depth};
  // At a dot nobody said how far off the surface was (docs/adr/0034-shift-at-boundary-marks-only.md).
  const double off = boundary ? std::max(0.0, depth - 0.5 * voxel) : 0;
  return was ? Correction{-1, -off, 0} : Correction{1, off, 0};
}

BandTerms EvidenceField::band_terms() const {
  BandTerms said;
  double sum = 0, count = unsaid_corrections;
  for (const Correction& correction : corrections_) sum += correction.way, count += std::abs(correction.way);
  said.offset_log_odds = settings_.surface_offset * sum / count;
  if (!voxels_->has_before() || !settings_.memory) return said;
  if (settings_.surface_memory == 0 && settings_.surface_pull == 0) return said;
  const auto marks = static_cast<double>(marks_.size());
  said.temporal_weight = settings_.surface_memory * marks / (marks + unsaid_marks);
  for (std::size_t m = fresh_; m < marks_.size(); ++m) {
    const Correction& correction = corrections_[m];
    if (correction.out_mm == 0 && correction.deep_mm == 0) continue;
    SurfaceMove& move = said.moves.emplace_back();
    const Eigen::Vector3d index = cells_.index_from_world() * marks_[m].position_mm;
    for (int a = 0; a < 3; ++a)
      move.at_mm[a] = static_cast<float>((index[a] - voxels_->box().first[a]) * cells_.spacing_mm[a]);
    move.out_voxels = static_cast<float>(correction.out_mm / cells_.spacing_mm.minCoeff());
    move.deep_mm = static_cast<float>(correction.deep_mm);
  }
  return said;
}

void EvidenceField::measure_reach(std::span<const Mark> marks) {
  Mark largest;
  for (const Mark& mark : marks)
    if (mark.kind != MarkKind::Outside && mark.radius_mm > largest.radius_mm) largest = mark;
  if (largest == largest_) return;
  largest_ = largest;
  const SeedScale scale = largest.kind == MarkKind::Inside
                              ? seed_scale(*volume_, largest.position_mm, largest.radius_mm)
                              : SeedScale{largest.radius_mm, false};
  reach_mm_ = scale.reach_mm;
  has_wall_ = scale.has_wall;
}

std::optional<Eigen::Vector3d> EvidenceField::middle_of_wrong(const Mark& mark, bool inside) const {
  constexpr double step_voxels = 0.25;
  const double voxel = cells_.spacing_mm.minCoeff();
  const Eigen::Vector3d way = (inside ? -voxel : voxel) * mark.outward.normalized();
  std::vector<double> far;
  std::vector<Eigen::Vector3d> places;
  for (double t = 0.5; t <= 0.5 + 2 * mark.radius_mm / voxel; t += step_voxels) {
    far.push_back(t);
    places.emplace_back(mark.position_mm + t * way);
  }
  const std::vector<std::uint8_t> was = voxels_->was_object(places);
  double sum = 0;
  int wrong = 0;
  for (std::size_t p = 0; p < places.size(); ++p)
    if ((was[p] != 0) != inside) sum += far[p], ++wrong;
  if (wrong == 0) return std::nullopt;
  return mark.position_mm + sum / wrong * way;
}

std::vector<NewMarkBall> EvidenceField::new_mark_balls() const {
  std::vector<NewMarkBall> fresh;
  std::vector<std::size_t> elsewhere;  // those that are not where their mark is
  std::vector<Eigen::Vector3d> centres;
  const auto add = [&](const Eigen::Vector3d& centre_mm, double radius_mm, bool inside) {
    elsewhere.push_back(fresh.size());
    centres.push_back(centre_mm);
    fresh.push_back({centre_mm, radius_mm, inside, 0});
  };
  for (std::size_t m = fresh_; m < fresh_ + before_.size(); ++m) {
    const Mark& mark = marks_[m];
    if (mark.kind != MarkKind::Boundary) {
      fresh.push_back({mark.position_mm, mark.radius_mm, mark.kind == MarkKind::Inside, before_[m - fresh_].depth_mm});
      continue;
    }
    const std::size_t had = fresh.size();
    for (const bool inside : {true, false})
      if (const auto middle = middle_of_wrong(mark, inside)) add(*middle, mark.radius_mm, inside);
    if (fresh.size() > had) continue;
    const Eigen::Vector3d step = ball_offset(mark);
    add(mark.position_mm - step, mark.radius_mm, true);
    add(mark.position_mm + step, mark.radius_mm, false);
  }
  if (centres.empty()) return fresh;
  const std::vector<FieldSolver::Before> before = voxels_->before(centres);
  for (std::size_t e = 0; e < elsewhere.size(); ++e) fresh[elsewhere[e]].depth_mm = before[e].depth_mm;
  return fresh;
}

void EvidenceField::take(const FieldSolver::Solved& solved) {
  report_.iterations = solved.iterations;
  report_.error = solved.error;
  around_ = solved.around;
  object_mm3_ = static_cast<double>(solved.count) * cells_.spacing_mm.prod();
  border_share_ = solved.border_share;
}

bool EvidenceField::spreads(const VoxelBox& grown) const {
  const double ball_mm3 = 4 * std::numbers::pi / 3 * std::pow(reach_mm_, 3);
  const double box_mm3 = static_cast<double>(around_.voxel_count()) * cells_.spacing_mm.prod();
  if (!has_wall_ || object_mm3_ <= settings_.max_volume * ball_mm3 || object_mm3_ < kLeastFill * box_mm3) return false;
  int moved = 0;
  for (int a = 0; a < 3; ++a) {
    moved += grown.first[a] < box_.first[a];
    moved += grown.first[a] + grown.size[a] > box_.first[a] + box_.size[a];
  }
  return border_share_ >= leak_share || moved > kMostCutSides;
}

void EvidenceField::update(std::span<const Mark> marks, std::span<const Mark> others, const ReportProgress& report) {
  check(marks);
  UpdateProgress& progress = voxels_->progress();
  progress.start(report);
  const VolumeGeometry& volume = volume_->geometry();
  measure_reach(marks);
  set_region(box_around(region_, box_around_marks(marks, volume, settings_.margin_share, settings_.least_margin)));
  report_ = {};
  remember(marks);
  // Rough fields let the box grow; once it no longer does the field is solved to the end, which may show it more. One
  // that held the object the last time mostly does.
  const double rough = std::max(growing_tolerance, settings_.tolerance);
  double tolerance = box_ == voxels_->box() ? settings_.tolerance : rough;
  const auto solve_in_box = [&] {
    progress.begin_pass(!(settings_.tolerance < tolerance));
    voxels_->set_box(cell_, box_, reach_mm_);
    look_back();
    voxels_->set_constraints(marks_, others);
    progress.advance(FieldPhase::Constraints);
    report_.beta = voxels_->learn(marks_, new_mark_balls(), reach_mm_, largest_.radius_mm);
    progress.advance(FieldPhase::Features);
    take(voxels_->solve(tolerance, false));
    progress.advance(FieldPhase::Walker);
  };
  VoxelBox before_growth = region_;
  const auto grows = [&] {
    if (report_.stopped || around_.voxel_count() == 0 || report_.growths == most_growths) return false;
    const VoxelBox grown = grow_around(box_, around_, cells_);
    if (grown == box_) return false;
    if (spreads(grown)) {
      report_.stopped = true;
      if (report_.growths == 0) return false;
      set_region(before_growth);
      return true;
    }
    before_growth = region_;
    set_region(voxels_around(grown, cell_, volume.size));
    tolerance = rough;
    ++report_.growths;
    return true;
  };
  do {
    do solve_in_box();
    while (grows());
    if (settings_.tolerance < tolerance) {
      progress.begin_pass(true);
      take(voxels_->solve(settings_.tolerance, true));
      progress.advance(FieldPhase::Walker);
    }
  } while (grows());
  const FieldSolver::RefinedSurface settled = voxels_->refine_surface(band_terms());
  progress.advance(FieldPhase::Surface);
  report_.expected_dice = settled.expected_dice;  // of what there was before: looks are surer than they are right
  around_ = settled.found.around;
  report_.leaks = report_.stopped || (around_.voxel_count() > 0 && settled.found.border_share >= leak_share &&
                                      reaches_sides(around_, box_, cells_, kNearSide * cells_.spacing_mm.minCoeff()));
}

Mask EvidenceField::object() const {
  if (cell_ == kVoxelCells) return mask_of(volume_->geometry(), box(), object_in_box().voxels);
  constexpr float kScale = std::numeric_limits<std::uint16_t>::max(), kMargin = kThresholdMargin * kScale;
  const std::span<const float> p = probability();
  const std::vector<std::uint8_t>& object = object_in_box().voxels;
  std::vector<std::uint16_t> values(object.size());
  for (std::size_t v = 0; v < values.size(); ++v)
    values[v] = static_cast<std::uint16_t>(object[v] ? std::max(kScale * p[v], 0.5f * kScale + kMargin)
                                                     : std::min(kScale * p[v], 0.5f * kScale - kMargin));
  return mask_above(volume_->geometry(), cell_, box(), values, 0.5f * kScale);
}

double EvidenceField::brush_mm(MarkKind kind, const Eigen::Vector3d& position_mm) const {
  return brush_radius_mm(cells_, box(), object_in_box().voxels, voxels_->known(), kind, position_mm, settings_);
}

std::size_t EvidenceField::bytes() const { return voxels_->bytes(); }

}  // namespace simplexseg
