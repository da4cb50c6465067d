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
#include "field/open_sides.h"
#include "field/seed_scale.h"
#include "field/stroke.h"

namespace simplexseg {
namespace {

constexpr int kMostGrowths = 12;
constexpr double kGrowingTolerance = 0.1;     // of the solver while the box grows
constexpr double kLeakShare = 0.05;           // share of the object in the cells near the sides of the box
constexpr double kAlwaysExceeds = 3;          // multiple of max_volume above which an object spreads wherever it grows
constexpr double kReported = 2.5;             // multiple above which a complete object is reported as spreading
constexpr int kMostCutSides = 3;              // sides by which a corner of a box cuts an object
constexpr double kHalfOffsetCorrections = 4;  // equal corrections with half of the largest offset
constexpr double kHalfWeightMarks = 10;       // marks with half of the largest temporal weight
constexpr double kMissedShare = 0.51;         // of 1 - expected Dice of independent cells (Report::expected_dice)
constexpr double kExtentOfScales = 6;         // extent of the median reference object, object scales

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
  solver_ = make(*volume_, run, settings_);
  main_ = *volume_;
  cells_ = volume_->geometry();
}

void EvidenceField::set_images(FieldImages images) {
  const auto check_grid = [&](const Volume& image) {
    if (!image.geometry().same_grid(volume_->geometry()))
      throw Error("an image of the segmentation field", "it is not on the grid of the volume", "resample it first");
  };
  if (!images.main.empty()) check_grid(images.main);
  for (const Volume& image : images.further) check_grid(image);
  main_ = images.main.empty() ? *volume_ : images.main;
  solver_->set_images(std::move(images));
}

void EvidenceField::set_region(const VoxelBox& voxels) {
  const VolumeGeometry& volume = volume_->geometry();
  region_ = voxels;
  cell_ = cell_size_for(voxels, volume, scale_mm_, settings_);
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

bool EvidenceField::restore(std::span<const Mark> marks, const CellSize& cell, const VoxelBox& box,
                            std::span<const float> probability) {
  check(marks);
  measure_scale(marks);
  set_region(voxels_around(box, cell, volume_->geometry().size));
  if (cell_ != cell || box_ != box) return false;
  solver_->discard_previous();
  solver_->set_box(cell_, box_, scale_mm_);
  open_sides_ = previous_open_sides_ = {};
  solver_->set_constraints(marks, {}, open_sides_);
  record(solver_->restore(probability));
  marks_.assign(marks.begin(), marks.end());
  corrections_.assign(marks.size(), {});
  first_new_mark_ = marks.size();
  previous_sides_.clear();
  return true;
}

void EvidenceField::set_marks(std::span<const Mark> marks) {
  const auto same = static_cast<std::size_t>(
      std::mismatch(marks_.begin(), marks_.end(), marks.begin(), marks.end()).first - marks_.begin());
  const auto are_local = [](std::span<const Mark> some) { return std::ranges::all_of(some, &Mark::local); };
  removed_local_ = same == marks.size() && same == first_new_mark_ && marks_.size() > same &&
                   are_local(std::span<const Mark>(marks_).subspan(same));
  if (same == marks_.size() && marks.size() > same) {
    solver_->store_previous(are_local(marks.subspan(same)));
    previous_open_sides_ = open_sides_;
    first_new_mark_ = same;
  } else if (same < first_new_mark_) {
    solver_->discard_previous();
    previous_open_sides_ = {};
    first_new_mark_ = same;
  }
  open_sides_ = previous_open_sides_;
  std::vector<Correction> corrections;
  for (const Mark& mark : marks) {
    const auto old = std::find(marks_.begin(), marks_.end(), mark);
    corrections.push_back(old == marks_.end() ? Correction{} : corrections_[old - marks_.begin()]);
  }
  corrections_ = std::move(corrections);
  marks_.assign(marks.begin(), marks.end());
}

bool EvidenceField::is_local() const {
  const std::span<const Mark> new_marks = std::span(marks_).subspan(first_new_mark_);
  return new_marks.empty() ? removed_local_ : std::ranges::all_of(new_marks, &Mark::local);
}

void EvidenceField::find_corrections() {
  previous_sides_.clear();
  if (!solver_->has_previous()) return;
  std::vector<Eigen::Vector3d> places;
  for (std::size_t m = first_new_mark_; m < marks_.size(); ++m) places.push_back(marks_[m].position_mm);
  previous_sides_ = solver_->previous_sides(places);
  for (std::size_t m = first_new_mark_; m < marks_.size(); ++m)
    corrections_[m] = correction_of(marks_[m], previous_sides_[m - first_new_mark_]);
}

EvidenceField::Correction EvidenceField::correction_of(const Mark& mark,
                                                       const FieldSolver::PreviousSide& previous) const {
  const bool in_object = previous.object;
  if (mark.kind == (in_object ? MarkKind::Inside : MarkKind::Outside)) return {};
  const double voxel = cells_.spacing_mm.minCoeff(), depth = previous.depth_mm;
  const bool boundary = mark.kind == MarkKind::Boundary;
  // Inside and outside marks are placed in the middle of an error, boundary marks at its end.
  if (depth > (boundary ? 2 : 1) * settings_.band_half_width * voxel) return {0, 0, depth};
  // Only boundary marks measure the error of the surface (docs/adr/0034-shift-at-boundary-marks-only.md).
  const double error = boundary ? std::max(0.0, depth - 0.5 * voxel) : 0;
  return in_object ? Correction{-1, -error, 0} : Correction{1, error, 0};
}

BandTerms EvidenceField::band_terms() const {
  BandTerms terms;
  double sum = 0, count = kHalfOffsetCorrections;
  for (std::size_t m = 0; m < marks_.size(); ++m)
    if (marks_[m].link != MarkLink::Stroke) sum += corrections_[m].sign, count += std::abs(corrections_[m].sign);
  terms.offset_log_odds = settings_.band_offset * sum / count;
  if (!solver_->has_previous() || !settings_.memory) return terms;
  if (settings_.temporal_weight == 0 && settings_.shift_weight == 0) return terms;
  const double prompts = prompt_count(marks_);
  terms.temporal_weight = settings_.temporal_weight * prompts / (prompts + kHalfWeightMarks);
  for (std::size_t m = first_new_mark_; m < marks_.size(); ++m) {
    const Correction& correction = corrections_[m];
    if (correction.outward_mm == 0 && correction.error_depth_mm == 0) continue;
    SurfaceShift& shift = terms.shifts.emplace_back();
    const Eigen::Vector3d index = cells_.index_from_world() * marks_[m].position_mm;
    for (int a = 0; a < 3; ++a)
      shift.at_mm[a] = static_cast<float>((index[a] - solver_->box().first[a]) * cells_.spacing_mm[a]);
    shift.outward_voxels = static_cast<float>(correction.outward_mm / cells_.spacing_mm.minCoeff());
    shift.error_depth_mm = static_cast<float>(correction.error_depth_mm);
  }
  return terms;
}

void EvidenceField::measure_scale(std::span<const Mark> marks) {
  Mark largest;
  for (const Mark& mark : marks)
    if (mark.kind != MarkKind::Outside && mark.radius_mm > largest.radius_mm) largest = mark;
  if (largest == largest_) return;
  largest_ = largest;
  const SeedScale scale = largest.kind == MarkKind::Inside ? seed_scale(main_, largest.position_mm, largest.radius_mm)
                                                           : SeedScale{largest.radius_mm, false};
  scale_mm_ = scale.scale_mm;
  has_edges_ = scale.has_edges;
}

std::optional<Eigen::Vector3d> EvidenceField::centre_of_error(const Mark& mark, bool inside) const {
  constexpr double kStepVoxels = 0.25;
  const double voxel = cells_.spacing_mm.minCoeff();
  const Eigen::Vector3d direction = (inside ? -voxel : voxel) * mark.outward.normalized();
  std::vector<double> distances;
  std::vector<Eigen::Vector3d> places;
  for (double t = 0.5; t <= 0.5 + 2 * mark.radius_mm / voxel; t += kStepVoxels) {
    distances.push_back(t);
    places.emplace_back(mark.position_mm + t * direction);
  }
  const std::vector<std::uint8_t> in_object = solver_->previous_object(places);
  double sum = 0;
  int wrong = 0;
  for (std::size_t p = 0; p < places.size(); ++p)
    if ((in_object[p] != 0) != inside) sum += distances[p], ++wrong;
  if (wrong == 0) return std::nullopt;
  return mark.position_mm + sum / wrong * direction;
}

std::vector<NewMarkBall> EvidenceField::new_mark_balls() const {
  std::vector<NewMarkBall> new_balls;
  std::vector<std::size_t> boundary_balls;
  std::vector<Eigen::Vector3d> centres;
  const auto add = [&](const Eigen::Vector3d& centre_mm, double radius_mm, bool inside) {
    boundary_balls.push_back(new_balls.size());
    centres.push_back(centre_mm);
    new_balls.push_back({centre_mm, radius_mm, inside, 0});
  };
  for (std::size_t m = first_new_mark_; m < first_new_mark_ + previous_sides_.size(); ++m) {
    const Mark& mark = marks_[m];
    if (mark.kind != MarkKind::Boundary) {
      new_balls.push_back({mark.position_mm, mark.radius_mm, mark.kind == MarkKind::Inside,
                           previous_sides_[m - first_new_mark_].depth_mm});
      continue;
    }
    const std::size_t count = new_balls.size();
    for (const bool inside : {true, false})
      if (const auto centre = centre_of_error(mark, inside)) add(*centre, mark.radius_mm, inside);
    if (new_balls.size() > count) continue;
    const Eigen::Vector3d step = ball_offset(mark);
    add(mark.position_mm - step, mark.radius_mm, true);
    add(mark.position_mm + step, mark.radius_mm, false);
  }
  if (centres.empty()) return new_balls;
  const std::vector<FieldSolver::PreviousSide> previous = solver_->previous_sides(centres);
  for (std::size_t b = 0; b < boundary_balls.size(); ++b) new_balls[boundary_balls[b]].depth_mm = previous[b].depth_mm;
  return new_balls;
}

void EvidenceField::record(const FieldSolver::Solved& solved) {
  report_.iterations = solved.iterations;
  report_.error = solved.error;
  bounds_ = solved.bounds;
  object_mm3_ = static_cast<double>(solved.count) * cells_.spacing_mm.prod();
  border_share_ = solved.border_share;
}

double EvidenceField::ball_mm3() const {
  const double scale_mm = std::max(scale_mm_, marked_extent(marks_) / kExtentOfScales);
  return 4 * std::numbers::pi / 3 * std::pow(scale_mm, 3);
}

bool EvidenceField::exceeds_volume(const VoxelBox& grown) const {
  const double most_mm3 = settings_.max_volume * ball_mm3();
  if (!has_edges_ || object_mm3_ <= most_mm3) return false;
  if (object_mm3_ > kAlwaysExceeds * most_mm3) return true;
  if (grown == box_) return false;
  int moved = 0;
  for (int a = 0; a < 3; ++a) {
    moved += grown.first[a] < box_.first[a];
    moved += grown.first[a] + grown.size[a] > box_.first[a] + box_.size[a];
  }
  return border_share_ >= kLeakShare || moved > kMostCutSides;
}

bool EvidenceField::open_cut_sides() {
  if (report_.stopped || !settings_.open_cut_sides || !is_near_closed_side(cells_, box_, bounds_, open_sides_))
    return false;
  const BoxSides cut =
      cut_sides(cells_, box_, object_in_box().voxels, solver_->smoothed_image(), solver_->constraints(), open_sides_);
  for (int a = 0; a < 3; ++a) {
    open_sides_.first[a] |= cut.first[a];
    open_sides_.last[a] |= cut.last[a];
  }
  return cut.any();
}

void EvidenceField::update(std::span<const Mark> marks, std::span<const Mark> others, const ReportProgress& report,
                           const std::function<void()>& box_solved) {
  check(marks);
  UpdateProgress& progress = solver_->progress();
  progress.start(report);
  const VolumeGeometry& volume = volume_->geometry();
  measure_scale(marks);
  set_region(box_around(region_, box_around_marks(marks, volume, settings_.margin_share, settings_.least_margin)));
  double share = 0;
  if (make_shape_prior_) {
    std::shared_ptr<const ShapePrior> prior = make_shape_prior_(marks);
    if (prior) share = prior->share;
    if (prior) set_region(box_around(region_, box_around_bounds(prior->bounds_mm, volume, settings_.least_margin)));
    solver_->set_shape_prior(std::move(prior));
  }
  report_ = {};
  report_.shape_prior_share = share;
  set_marks(marks);
  // The box grows by solutions of a larger tolerance; the final solution may require further growth. The box of the
  // last update is usually large enough.
  const double growing_tolerance = std::max(kGrowingTolerance, settings_.tolerance);
  double tolerance = box_ == solver_->box() ? settings_.tolerance : growing_tolerance;
  double published_mm3 = 0;  // volume of the object at the last call of box_solved
  const auto solve_in_box = [&] {
    progress.begin_pass(!(settings_.tolerance < tolerance));
    solver_->set_box(cell_, box_, scale_mm_);
    find_corrections();
    solver_->set_constraints(marks_, others, open_sides_);
    progress.advance(FieldPhase::Constraints);
    report_.beta = solver_->compute_prior(marks_, new_mark_balls(), scale_mm_, largest_.radius_mm);
    progress.advance(FieldPhase::Features);
    record(solver_->solve(tolerance, false));
    progress.advance(FieldPhase::Walker);
    if (!box_solved || object_mm3_ < 2 * published_mm3 || object_mm3_ == 0) return;
    published_mm3 = object_mm3_;
    box_solved();
  };
  VoxelBox before_growth = region_;
  VolumeInBoxes volumes;
  const auto grows = [&] {
    if (report_.stopped || bounds_.voxel_count() == 0 || report_.growths == kMostGrowths) return false;
    const VoxelBox grown = grow_around(box_, bounds_, cells_);
    const bool leaks = volumes.add(object_mm3_, region_);
    if ((leaks || exceeds_volume(grown)) && !is_thin(object_mm3_, bounds_, cells_.spacing_mm)) {
      report_.stopped = true;
      if (report_.growths == 0) return false;
      set_region(leaks ? volumes.constant_in() : before_growth);
      return true;
    }
    if (grown == box_) return false;
    before_growth = region_;
    set_region(voxels_around(grown, cell_, volume.size));
    tolerance = growing_tolerance;
    ++report_.growths;
    return true;
  };
  const auto opens = [&] {
    if (!open_cut_sides()) return false;
    volumes = {};  // the object now extends to these sides
    return true;
  };
  do {
    do solve_in_box();
    while (grows() || opens());
    if (settings_.tolerance < tolerance) {
      progress.begin_pass(true);
      record(solver_->solve(settings_.tolerance, true));
      progress.advance(FieldPhase::Walker);
    }
  } while (grows());
  const FieldSolver::RefinedSurface refined = solver_->refine_surface(band_terms());
  progress.advance(FieldPhase::Surface);
  report_.expected_dice = refined.expected_dice > 0 ? 1 - kMissedShare * (1 - refined.expected_dice) : 0;
  report_.open_sides = open_sides_;
  FieldSolver::Solved found = refined.found;
  if (solver_->has_previous() && settings_.memory && is_local()) {
    found = solver_->damp_far_change(new_mark_balls(), settings_.local_depths, 0);
  } else if (!previous_sides_.empty() && settings_.memory && settings_.far_change > 0) {
    const double part = prompt_count(marks_) / settings_.far_change;
    found = solver_->damp_far_change(new_mark_balls(), settings_.far_change_depths, 1 / (1 + part * part));
  }
  bounds_ = found.bounds;
  report_.leaks = report_.stopped || spreads(found);
}

bool EvidenceField::spreads(const FieldSolver::Solved& found) const {
  if (found.count == 0) return false;
  const double near_mm = kNearSide * cells_.spacing_mm.minCoeff();
  if (found.border_share >= kLeakShare && reaches_sides(found.bounds, box_, cells_, near_mm)) return true;
  const double mm3 = static_cast<double>(found.count) * cells_.spacing_mm.prod();
  return has_edges_ && mm3 > kReported * settings_.max_volume * ball_mm3() &&
         !is_thin(mm3, found.bounds, cells_.spacing_mm);
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
  return brush_radius_mm(cells_, box(), object_in_box().voxels, kind, position_mm, settings_);
}

std::size_t EvidenceField::bytes() const { return solver_->bytes(); }

}  // namespace simplexseg
