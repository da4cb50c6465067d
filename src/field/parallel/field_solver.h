// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/expect.h"
#include "field/cell_resampling.h"
#include "field/conductances.h"
#include "field/field_solver.h"
#include "field/field_voxel.h"
#include "field/parallel/constraints.h"
#include "field/parallel/executor.h"
#include "field/parallel/far_change.h"
#include "field/parallel/field_values.h"
#include "field/parallel/inner_difference.h"
#include "field/parallel/object.h"
#include "field/parallel/previous_field.h"
#include "field/parallel/prior.h"
#include "field/parallel/smooth.h"
#include "field/parallel/surface.h"
#include "field/parallel/walker.h"

namespace simplexseg {

/// Fixed (Dirichlet) cells and their values.
struct FixConstrained {
  const Constraint* constraints;
  std::uint8_t* fixed;  ///< not 0 for open cells (OpenVoxel); receives 1 for fixed cells, else 0
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    const bool is_fixed = is_dirichlet(constraints[v]) && fixed[v] == 0;
    fixed[v] = is_fixed ? 1 : 0;
    if (is_fixed) field[v] = constraints[v] == Constraint::Inside ? 1.0f : 0.0f;
  }
};

/// Field from the solution, before it is smoothed.
struct FieldOfSolution {
  InwardValue solution;
  const Constraint* constraints;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    field[v] = constraints[v] == Constraint::VolumeEdge ? solution(v) : solution.field[v];
  }
};
/// Field from the smoothed one: restores the values of marked cells.
struct ImposeMarks {
  const Constraint* constraints;
  const float* smoothed;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    const bool in = constraints[v] == Constraint::Inside, out = is_excluded(constraints[v]);
    field[v] = in ? 1.0f : out ? 0.0f : smoothed[v];
  }
};
struct StoreSolution {
  const float* field;
  std::uint16_t* stored;
  SIMPLEXSEG_HD void operator()(int v) const { stored[v] = to_16_bits(field[v]); }
};
struct LoadSolution {
  const std::uint16_t* stored;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const { field[v] = from_16_bits(stored[v]); }
};
struct StorePrevious {
  const float* field;
  const std::uint8_t* object;  ///< null: the value of each cell is stored; else of cells on the side of the object mask
  std::uint8_t* previous;
  SIMPLEXSEG_HD void operator()(int v) const {
    constexpr int kInObject = kPreviousThreshold + 2;  // smallest value that from_8_bits() makes larger than 0.5
    const int value = to_8_bits(field[v]);
    const bool too_small = object && object[v] != 0 && value < kInObject;
    const bool too_large = object && object[v] == 0 && value > kPreviousThreshold;
    previous[v] = static_cast<std::uint8_t>(too_small ? kInObject : too_large ? kPreviousThreshold : value);
  }
};

template <class T>
struct ResampleCells {
  CellResampling resampling;
  const T* from;
  T* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = resampling(v, from); }
};

/// Solver of a field on an executor: arrays stay in its memory between updates, and results are copied when they are
/// requested. Each update allocates its workspace and releases it.
template <class Executor>
class ParallelFieldSolver final : public FieldSolver {
 public:
  ParallelFieldSolver(const Volume& volume, const RunJobs& run, const EvidenceSettings& settings)
      : volume_(volume),
        run_(run),
        settings_(settings),
        executor_(run),
        constraint_mask_(executor_),
        prior_(executor_, settings_, run_) {}

  void set_box(const CellSize& cell, const VoxelBox& box, double scale_mm) override {
    const bool same_box = box == box_ && cell == cell_;
    if (same_box && scale_of_box_mm_ == scale_mm) return;
    const Volume& main = images_.main.empty() ? volume_ : images_.main;
    BoxImage image = extract_box(main, cell, box, run_);
    std::vector<BoxImage> further;
    for (const Volume& other : images_.further) {
      further.push_back(extract_box(other, cell, box, run_));
      fill_with_mean(further.back());
    }
    const VolumeGeometry cells = cell_geometry(volume_.geometry(), cell);
    prior_.set_box(image, cells, box.first, scale_mm, further);
    scale_of_box_mm_ = scale_mm;
    if (same_box) return;
    release_workspace();
    object_finder_.reset();
    const std::size_t n = box.voxel_count();
    const CellResampling resampling(cell_, box_, cell, box);
    cell_ = cell, cells_ = cells, box_ = box;
    for (int a = 0; a < 3; ++a) spacing_mm_[a] = cells.spacing_mm[a];
    finite_ = {};
    if (std::ranges::count(image.finite, std::uint8_t{0}) != 0)
      finite_ = executor_.copy_of(std::span<const std::uint8_t>(image.finite));
    image_ = executor_.copy_of(std::span<const float>(image.value));
    in_range_ = {};
    if (settings_.intensity_range.is_limited())
      in_range_ = executor_.copy_of(std::span<const std::uint8_t>(
          cells_in_range(volume_, cell, box, settings_.intensity_range, spacing_mm_, settings_.image_smoothing, run_)));
    smooth_by_least_spacing(image.value, image.grid, spacing_mm_, settings_.image_smoothing, run_);
    smoothed_ = executor_.copy_of(std::span<const float>(image.value));
    resample(resampling, solution_);
    if (has_previous_) resample(resampling, previous_);
    constraints_ = executor_.template array<Constraint>(n);
    probability_ = executor_.template array<float>(n);
    object_voxels_ = executor_.template array<std::uint8_t>(n);
    forget_copies();
  }

  void store_previous(bool only_object) override {
    if (probability_.size() == 0) return;
    previous_ = executor_.template array<std::uint8_t>(probability_.size());
    executor_.each(count(),
                   StorePrevious{probability_.data(), only_object ? object_voxels_.data() : nullptr, previous_.data()});
    has_previous_ = true;
  }
  Solved restore(std::span<const float> probability) override {
    SIMPLEXSEG_EXPECT(probability.size() == probability_.size());
    probability_ = executor_.copy_of(probability);
    solution_ = executor_.template array<std::uint16_t>(probability.size());
    executor_.each(count(), StoreSolution{probability_.data(), solution_.data()});
    const Solved found = find_object();
    object_finder_.reset();
    return found;
  }
  void discard_previous() override {
    has_previous_ = false;
    previous_ = {};
  }
  bool has_previous() const override { return has_previous_; }
  std::vector<std::uint8_t> previous_object(std::span<const Eigen::Vector3d> places_mm) const override {
    return simplexseg::previous_object(executor_, cells_, box_, previous_.data(), places_mm);
  }
  std::vector<PreviousSide> previous_sides(std::span<const Eigen::Vector3d> places_mm) const override {
    return simplexseg::previous_sides(executor_, cells_, box_, previous_.data(), places_mm);
  }

  void set_constraints(std::span<const Mark> marks, std::span<const Mark> others, const BoxSides& open) override {
    constraint_mask_.find(cells_, box_, finite_.data(), in_range_.data(), marks, others, constraints_.data(), open);
    host_constraints_.clear();
  }

  double compute_prior(std::span<const Mark> marks, std::span<const NewMarkBall> new_balls, double scale_mm,
                       double radius_mm) override {
    allocate_workspace();
    const auto difference =
        fetch_inner_difference(executor_, BoxGrid{box_.size}, spacing_mm_, smoothed_.data(), constraints_.data(),
                               box_around_inside(painted_balls(cells_, box_, marks)));
    const std::uint8_t* const previous = has_previous_ ? previous_.data() : nullptr;
    prior_.compute({marks, constraints_.data(), previous, new_balls, scale_mm, radius_mm, shape_prior_.get()},
                   &progress());
    beta_ = sharpness_of(received_inner_difference(executor_, difference), settings_);
    prior_.interpolate(smoothed_.data(), edge_difference(beta_), target_.data());
    return beta_;
  }

  Solved solve(double tolerance, bool resume) override {
    const ReportProgress report_progress = [this](float part) { progress().advance(FieldPhase::Walker, part); };
    if (resume) {
      walker_->resume(tolerance, settings_.most_iterations, report_progress);
    } else {
      const Array<std::uint8_t>& conducts = in_range_.size() != 0 ? in_range_ : finite_;
      set_edges(executor_, *walker_, spacing_mm_, smoothed_.data(), conducts.data(), beta_, prior_weight());
      executor_.clear(fixed_.data(), fixed_.size());
      prior_.mark_open(constraints_.data(), fixed_.data());
      executor_.each(count(), FixConstrained{constraints_.data(), fixed_.data(), walker_->field()});
      walker_->solve(target_.data(), fixed_.data(), tolerance, settings_.most_iterations, report_progress);
    }
    const auto report = walker_->fetch_report();
    executor_.each(count(), FieldOfSolution{{{box_.size[0], box_.size[1], box_.size[2]}, walker_->field()},
                                            constraints_.data(),
                                            smoothing_->data(0)});
    smoothing_->smooth_by_least_spacing(spacing_mm_, settings_.field_smoothing);
    executor_.each(count(), ImposeMarks{constraints_.data(), smoothing_->data(0), probability_.data()});
    Solved found = find_object();
    const typename ParallelWalker<Executor>::Report solved = walker_->report(report);
    found.iterations = solved.iterations, found.error = solved.error;
    return found;
  }

  RefinedSurface refine_surface(const BandTerms& terms) override {
    const auto expected = begin_expected_dice(executor_, count(), probability_.data(), object_voxels_.data());
    release_workspace();
    refine_in_narrow_band(executor_, probability_.data(), object_voxels_.data(), bounds_, constraints_.data(),
                          image_.data(), has_previous_ ? previous_.data() : nullptr, box_, spacing_mm_, terms,
                          settings_);
    const Solved found = find_object();
    object_finder_.reset();
    return {found, end_expected_dice(executor_, expected)};
  }

  Solved damp_far_change(std::span<const NewMarkBall> new_balls, double far_depths, double share) override {
    const auto marks = executor_.copy_of(std::span<const NewMarkDepth>(depths_of(new_balls, cells_, box_)));
    executor_.each_cell(BoxGrid{box_.size},
                        DampFarChange{marks.data(),
                                      static_cast<int>(new_balls.size()),
                                      {static_cast<float>(spacing_mm_[0]), static_cast<float>(spacing_mm_[1]),
                                       static_cast<float>(spacing_mm_[2])},
                                      static_cast<float>(far_depths),
                                      static_cast<float>(share),
                                      previous_.data(),
                                      constraints_.data(),
                                      probability_.data()});
    const Solved found = find_object();
    object_finder_.reset();
    return found;
  }

  std::span<const float> probability() const override {
    if constexpr (Executor::kHostMemory) return {probability_.data(), probability_.size()};
    if (host_probability_.empty()) copy_to_host(probability_, host_probability_);
    return host_probability_;
  }
  const FieldObject& object() const override {
    if (host_object_.voxels.empty()) {
      copy_to_host(object_voxels_, host_object_.voxels);
      host_object_.bounds = bounds_;
      host_object_.count = object_count_;
      host_object_.border_share = border_share_;
    }
    return host_object_;
  }
  std::span<const Constraint> constraints() const override {
    if constexpr (Executor::kHostMemory) return {constraints_.data(), constraints_.size()};
    if (host_constraints_.empty()) copy_to_host(constraints_, host_constraints_);
    return host_constraints_;
  }
  std::span<const float> smoothed_image() const override {
    if constexpr (Executor::kHostMemory) return {smoothed_.data(), smoothed_.size()};
    if (host_smoothed_.empty()) copy_to_host(smoothed_, host_smoothed_);
    return host_smoothed_;
  }
  std::vector<std::uint16_t> values(const FieldValue& value) const override {
    if (!are_orthogonal(cells_.world_from_index().linear()))
      return field_values(object().voxels, probability(), box_, cells_, value, run_);
    const auto squares = executor_.template array<float>(count()), scratch = executor_.template array<float>(count());
    const auto values = executor_.template array<std::uint16_t>(count());
    field_values(executor_, object_voxels_.data(), probability_.data(), BoxGrid{box_.size}, spacing_mm_, value,
                 squares.data(), scratch.data(), values.data());
    std::vector<std::uint16_t> on_host(count());
    executor_.download(values.data(), std::span<std::uint16_t>(on_host));
    return on_host;
  }
  void record_features(bool record) override { prior_.record_features(record); }
  const PriorFeatures& features() const override { return prior_.features(); }
  std::size_t bytes() const override {
    return finite_.bytes() + in_range_.bytes() + image_.bytes() + smoothed_.bytes() + previous_.bytes() +
           constraints_.bytes() + solution_.bytes() + target_.bytes() + fixed_.bytes() + probability_.bytes() +
           object_voxels_.bytes() + prior_.bytes() + (walker_ ? walker_->bytes() + smoothing_->bytes() : 0) +
           (object_finder_ ? object_finder_->bytes() : 0) +
           (host_probability_.size() + host_smoothed_.size()) * sizeof(float) + host_object_.voxels.size() +
           host_constraints_.size();
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  int count() const { return static_cast<int>(probability_.size()); }
  /// Weight of the prior between those without and with a shape prior.
  double prior_weight() const {
    if (settings_.prior_weight == 0) return 0;
    const double share = shape_prior_ ? shape_prior_->share : 0;
    return std::pow(settings_.prior_weight, 1 - share) * std::pow(settings_.shape_prior_weight, share);
  }
  void allocate_workspace() {
    if (walker_) return;
    const BoxGrid grid{box_.size};
    target_ = executor_.template array<std::uint8_t>(count());
    fixed_ = executor_.template array<std::uint8_t>(count());
    smoothing_ = std::make_unique<SmoothedFields<Executor, 1>>(executor_, grid);
    walker_ = std::make_unique<ParallelWalker<Executor>>(grid, spacing_mm_, executor_);
    if (solution_.size() != 0) executor_.each(count(), LoadSolution{solution_.data(), walker_->field()});
  }
  /// Releases the workspace and stores the solution, from which the next update starts.
  void release_workspace() {
    if (!walker_) return;
    solution_ = executor_.template array<std::uint16_t>(count());
    executor_.each(count(), StoreSolution{walker_->field(), solution_.data()});
    walker_.reset();
    smoothing_.reset();
    target_ = {};
    fixed_ = {};
    prior_.release_workspace();
  }
  template <class T>
  void resample(const CellResampling& resampling, Array<T>& values) const {
    if (values.size() == 0) return;
    Array<T> resampled = executor_.template array<T>(box_.voxel_count());
    executor_.each(static_cast<int>(resampled.size()), ResampleCells<T>{resampling, values.data(), resampled.data()});
    values = std::move(resampled);
  }
  template <class T>
  void copy_to_host(const Array<T>& from, std::vector<T>& to) const {
    to.resize(from.size());
    executor_.download(from.data(), std::span<T>(to));
  }
  void forget_copies() {
    host_smoothed_.clear();
    host_probability_.clear();
    host_object_.voxels.clear();
    host_constraints_.clear();
  }
  Solved find_object() {
    if (!object_finder_) object_finder_ = std::make_unique<ParallelObject<Executor>>(executor_, box_);
    const auto found = object_finder_->find(probability_.data(), constraints_.data(), object_voxels_.data());
    bounds_ = found.bounds, object_count_ = found.count, border_share_ = found.border_share;
    host_probability_.clear();
    host_object_.voxels.clear();
    return {0, 0, bounds_, object_count_, border_share_};
  }

  const Volume& volume_;
  RunJobs run_;
  EvidenceSettings settings_;
  Executor executor_;                   // its arrays must not outlive it
  std::array<double, 3> spacing_mm_{};  ///< of the cells
  double scale_of_box_mm_ = 0;          // object scale for which the blocks of the prior were computed
  double beta_ = 0;
  Array<std::uint8_t> finite_;    // empty if all cells are finite
  Array<std::uint8_t> in_range_;  // empty without a range
  Array<std::uint8_t> previous_;
  Array<float> image_, smoothed_, probability_;
  Array<Constraint> constraints_;
  Array<std::uint8_t> object_voxels_;
  Array<std::uint16_t> solution_;  // of the random walker, between updates
  bool has_previous_ = false;
  ConstraintMask<Executor> constraint_mask_;
  ParallelPrior<Executor> prior_;
  // Workspace of an update.
  Array<std::uint8_t> target_, fixed_;
  std::unique_ptr<ParallelWalker<Executor>> walker_;
  std::unique_ptr<SmoothedFields<Executor, 1>> smoothing_;
  std::unique_ptr<ParallelObject<Executor>> object_finder_;
  VoxelBox bounds_{};
  std::size_t object_count_ = 0;
  double border_share_ = 0;
  mutable std::vector<float> host_probability_, host_smoothed_;
  mutable FieldObject host_object_;
  mutable std::vector<Constraint> host_constraints_;
};

}  // namespace simplexseg
