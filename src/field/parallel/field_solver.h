// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "field/cell_resampling.h"
#include "field/conductances.h"
#include "field/field_solver.h"
#include "field/field_voxel.h"
#include "field/parallel/constraints.h"
#include "field/parallel/executor.h"
#include "field/parallel/field_values.h"
#include "field/parallel/inner_difference.h"
#include "field/parallel/object.h"
#include "field/parallel/previous_field.h"
#include "field/parallel/prior.h"
#include "field/parallel/smooth.h"
#include "field/parallel/surface.h"
#include "field/parallel/walker.h"

namespace simplexseg {

/// What is held, and its value; `open`: not 0 where it is not held all the same.
struct HoldKnown {
  const Constraint* known;
  std::uint8_t* open;  ///< becomes: held
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    const bool held = is_dirichlet(known[v]) && open[v] == 0;
    open[v] = held ? 1 : 0;
    if (held) field[v] = known[v] == Constraint::Inside ? 1.0f : 0.0f;
  }
};

/// The solution as the field, before it is smoothed.
struct TakeSolution {
  FromInner solution;
  const Constraint* known;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    field[v] = known[v] == Constraint::VolumeEdge ? solution(v) : solution.field[v];
  }
};
/// Smoothing must not take back what was said.
struct KeepSaid {
  const Constraint* known;
  const float* smoothed;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    const bool in = known[v] == Constraint::Inside, out = is_excluded(known[v]);
    field[v] = in ? 1.0f : out ? 0.0f : smoothed[v];
  }
};
struct KeepSolution {
  const float* field;
  std::uint16_t* kept;
  SIMPLEXSEG_HD void operator()(int v) const { kept[v] = as_kept(field[v]); }
};
struct TakeKept {
  const std::uint16_t* kept;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const { field[v] = of_kept(kept[v]); }
};
struct KeepBefore {
  const float* field;
  std::uint8_t* before;
  SIMPLEXSEG_HD void operator()(int v) const { before[v] = as_before(field[v]); }
};

template <class T>
struct ResampleCells {
  CellResampling resampling;
  const T* from;
  T* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = resampling(v, from); }
};

/// Solver of a field on an executor: the cells stay in its memory from one update to the next, and results are copied
/// when they are requested. Memory that only an update needs is allocated by each of them.
template <class Executor>
class ParallelFieldSolver final : public FieldSolver {
 public:
  ParallelFieldSolver(const Volume& volume, const RunJobs& run, const EvidenceSettings& settings)
      : volume_(volume),
        run_(run),
        settings_(settings),
        executor_(run),
        known_voxels_(executor_),
        prior_(executor_, settings_, run_) {}

  void set_box(const CellSize& cell, const VoxelBox& box, double reach_mm) override {
    const bool same_box = box == box_ && cell == cell_;
    if (same_box && reach_of_box_mm_ == reach_mm) return;
    BoxImage image = cut_out(volume_, cell, box, run_);
    const VolumeGeometry cells = cell_geometry(volume_.geometry(), cell);
    prior_.set_box(image, cells, box.first, reach_mm);
    reach_of_box_mm_ = reach_mm;
    if (same_box) return;
    put_work_away();
    object_finder_.reset();
    const std::size_t n = box.voxel_count();
    const CellResampling resampling(cell_, box_, cell, box);
    cell_ = cell, cells_ = cells, box_ = box;
    for (int a = 0; a < 3; ++a) spacing_mm_[a] = cells.spacing_mm[a];
    finite_ = {};
    if (std::ranges::count(image.finite, std::uint8_t{0}) != 0)
      finite_ = executor_.copy_of(std::span<const std::uint8_t>(image.finite));
    image_ = executor_.copy_of(std::span<const float>(image.value));
    smooth_by_least_spacing(image.value, image.grid, spacing_mm_, settings_.image_smoothing, run_);
    smoothed_ = executor_.copy_of(std::span<const float>(image.value));
    resample(resampling, solution_);
    if (has_before_) resample(resampling, before_);
    known_ = executor_.template array<Constraint>(n);
    probability_ = executor_.template array<float>(n);
    object_voxels_ = executor_.template array<std::uint8_t>(n);
    forget_copies();
  }

  void keep_before() override {
    if (probability_.size() == 0) return;
    before_ = executor_.template array<std::uint8_t>(probability_.size());
    executor_.each(count(), KeepBefore{probability_.data(), before_.data()});
    has_before_ = true;
  }
  void forget_before() override {
    has_before_ = false;
    before_ = {};
  }
  bool has_before() const override { return has_before_; }
  std::vector<std::uint8_t> was_object(std::span<const Eigen::Vector3d> places_mm) const override {
    return simplexseg::was_object(executor_, cells_, box_, before_.data(), places_mm);
  }
  std::vector<Before> before(std::span<const Eigen::Vector3d> places_mm) const override {
    return before_at(executor_, cells_, box_, before_.data(), places_mm);
  }

  void set_constraints(std::span<const Mark> marks, std::span<const Mark> others) override {
    known_voxels_.find(cells_, box_, finite_.data(), marks, others, known_.data());
    host_known_.clear();
  }

  double learn(std::span<const Mark> marks, std::span<const NewMarkBall> fresh, double reach_mm,
               double radius_mm) override {
    take_work_out();
    const auto difference =
        fetch_inner_difference(executor_, BoxGrid{box_.size}, spacing_mm_, smoothed_.data(), known_.data(),
                               box_around_inside(painted_balls(cells_, box_, marks)));
    const std::uint8_t* const before = has_before_ ? before_.data() : nullptr;
    prior_.learn({marks, known_.data(), before, fresh, reach_mm, radius_mm}, &progress());
    beta_ = sharpness_of(received_inner_difference(executor_, difference), settings_);
    prior_.interpolate(smoothed_.data(), edge_of(beta_), target_.data());
    return beta_;
  }

  Solved solve(double tolerance, bool further) override {
    const ReportProgress report_progress = [this](float part) { progress().advance(FieldPhase::Walker, part); };
    if (further) {
      walker_->resume(tolerance, settings_.most_iterations, report_progress);
    } else {
      set_edges(executor_, *walker_, spacing_mm_, smoothed_.data(), finite_.data(), beta_, settings_.prior_pull);
      executor_.clear(held_.data(), held_.size());
      prior_.mark_open(known_.data(), held_.data());
      executor_.each(count(), HoldKnown{known_.data(), held_.data(), walker_->field()});
      walker_->solve(target_.data(), held_.data(), tolerance, settings_.most_iterations, report_progress);
    }
    const auto report = walker_->fetch_report();
    executor_.each(count(), TakeSolution{{{box_.size[0], box_.size[1], box_.size[2]}, walker_->field()},
                                         known_.data(),
                                         smoothing_->data(0)});
    smoothing_->smooth_by_least_spacing(spacing_mm_, settings_.field_smoothing);
    executor_.each(count(), KeepSaid{known_.data(), smoothing_->data(0), probability_.data()});
    Solved found = find_object();
    const typename ParallelWalker<Executor>::Report solved = walker_->report(report);
    found.iterations = solved.iterations, found.error = solved.error;
    return found;
  }

  RefinedSurface refine_surface(const BandTerms& said) override {
    const auto expected = begin_expected_dice(executor_, count(), probability_.data(), object_voxels_.data());
    put_work_away();
    refine_in_narrow_band(executor_, probability_.data(), object_voxels_.data(), around_, known_.data(), image_.data(),
                          has_before_ ? before_.data() : nullptr, box_, spacing_mm_, said, settings_);
    const Solved found = find_object();
    object_finder_.reset();
    return {found, end_expected_dice(executor_, expected)};
  }

  std::span<const float> probability() const override {
    if constexpr (Executor::kHostMemory) return {probability_.data(), probability_.size()};
    if (host_probability_.empty()) copy_to_host(probability_, host_probability_);
    return host_probability_;
  }
  const FieldObject& object() const override {
    if (host_object_.voxels.empty()) {
      copy_to_host(object_voxels_, host_object_.voxels);
      host_object_.around = around_;
      host_object_.count = object_count_;
      host_object_.border_share = border_share_;
    }
    return host_object_;
  }
  std::span<const Constraint> known() const override {
    if constexpr (Executor::kHostMemory) return {known_.data(), known_.size()};
    if (host_known_.empty()) copy_to_host(known_, host_known_);
    return host_known_;
  }
  std::vector<std::uint16_t> values(const FieldValue& value) const override {
    if (!are_orthogonal(cells_.world_from_index().linear()))
      return field_values(object().voxels, probability(), box_, cells_, value, run_);
    const auto squares = executor_.template array<float>(count()), spare = executor_.template array<float>(count());
    const auto values = executor_.template array<std::uint16_t>(count());
    field_values(executor_, object_voxels_.data(), probability_.data(), BoxGrid{box_.size}, spacing_mm_, value,
                 squares.data(), spare.data(), values.data());
    std::vector<std::uint16_t> on_host(count());
    executor_.download(values.data(), std::span<std::uint16_t>(on_host));
    return on_host;
  }
  void record_features(bool record) override { prior_.record_features(record); }
  const PriorFeatures& features() const override { return prior_.features(); }
  std::size_t bytes() const override {
    return finite_.bytes() + image_.bytes() + smoothed_.bytes() + before_.bytes() + known_.bytes() + solution_.bytes() +
           target_.bytes() + held_.bytes() + probability_.bytes() + object_voxels_.bytes() + prior_.bytes() +
           (walker_ ? walker_->bytes() + smoothing_->bytes() : 0) + (object_finder_ ? object_finder_->bytes() : 0) +
           host_probability_.size() * sizeof(float) + host_object_.voxels.size() + host_known_.size();
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  int count() const { return static_cast<int>(probability_.size()); }
  void take_work_out() {
    if (walker_) return;
    const BoxGrid grid{box_.size};
    target_ = executor_.template array<std::uint8_t>(count());
    held_ = executor_.template array<std::uint8_t>(count());
    smoothing_ = std::make_unique<SmoothedFields<Executor, 1>>(executor_, grid);
    walker_ = std::make_unique<ParallelWalker<Executor>>(grid, spacing_mm_, executor_);
    if (solution_.size() != 0) executor_.each(count(), TakeKept{solution_.data(), walker_->field()});
  }
  /// The solution is where the next update starts.
  void put_work_away() {
    if (!walker_) return;
    solution_ = executor_.template array<std::uint16_t>(count());
    executor_.each(count(), KeepSolution{walker_->field(), solution_.data()});
    walker_.reset();
    smoothing_.reset();
    target_ = {};
    held_ = {};
    prior_.put_work_away();
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
    host_probability_.clear();
    host_object_.voxels.clear();
    host_known_.clear();
  }
  Solved find_object() {
    if (!object_finder_) object_finder_ = std::make_unique<ParallelObject<Executor>>(executor_, box_);
    const auto found = object_finder_->find(probability_.data(), known_.data(), object_voxels_.data());
    around_ = found.around, object_count_ = found.count, border_share_ = found.border_share;
    host_probability_.clear();
    host_object_.voxels.clear();
    return {0, 0, around_, object_count_, border_share_};
  }

  const Volume& volume_;
  RunJobs run_;
  EvidenceSettings settings_;
  Executor executor_;                   // its arrays must not outlive it
  std::array<double, 3> spacing_mm_{};  ///< of the cells
  double reach_of_box_mm_ = 0;          // with which the prior's blocks were made
  double beta_ = 0;
  Array<std::uint8_t> finite_;  // none where all are
  Array<std::uint8_t> before_;
  Array<float> image_, smoothed_, probability_;
  Array<Constraint> known_;
  Array<std::uint8_t> object_voxels_;
  Array<std::uint16_t> solution_;  // of the walker
  bool has_before_ = false;
  ConstraintVoxels<Executor> known_voxels_;
  ParallelPrior<Executor> prior_;
  // While an update runs.
  Array<std::uint8_t> target_, held_;
  std::unique_ptr<ParallelWalker<Executor>> walker_;
  std::unique_ptr<SmoothedFields<Executor, 1>> smoothing_;
  std::unique_ptr<ParallelObject<Executor>> object_finder_;
  VoxelBox around_{};
  std::size_t object_count_ = 0;
  double border_share_ = 0;
  mutable std::vector<float> host_probability_;
  mutable FieldObject host_object_;
  mutable std::vector<Constraint> host_known_;
};

}  // namespace simplexseg
