// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "evidence/cell_resampling.h"
#include "evidence/conductances.h"
#include "evidence/field_solver.h"
#include "evidence/field_voxel.h"
#include "evidence/random_walker.h"
#include "evidence/surface_layer.h"

namespace simplexseg {
namespace {

constexpr float unreached_mm = 1e6f;

class CpuFieldSolver final : public FieldSolver {
 public:
  CpuFieldSolver(const Volume& volume, const RunJobs& run, const EvidenceSettings& settings)
      : volume_(volume), run_(run), settings_(settings), coarse_(run_, settings_) {}

  void set_box(const CellSize& cell, const VoxelBox& box, double reach_mm) override {
    const bool same_box = box == box_ && cell == cell_;
    if (same_box && reach_of_box_mm_ == reach_mm) return;
    BoxImage image = cut_out(volume_, cell, box, run_);
    const VolumeGeometry cells = cell_geometry(volume_.geometry(), cell);
    coarse_.set_box(image, cells, box.first, reach_mm);
    reach_of_box_mm_ = reach_mm;
    if (same_box) return;
    put_work_away();
    const CellResampling resampling(cell_, box_, cell, box);
    cell_ = cell, cells_ = cells, box_ = box;
    for (int a = 0; a < 3; ++a) spacing_mm_[a] = cells.spacing_mm[a];
    finite_ = image.finite;
    smoothed_ = image.value;
    image_ = std::move(image.value);
    smooth_by_least_spacing(smoothed_, image.grid, spacing_mm_, settings_.image_smoothing, run_);
    resample(resampling, solution_);
    resample(resampling, before_);
  }

  void keep_before() override {
    before_.resize(probability_.size());
    for_each_index(run_, static_cast<int>(before_.size()),
                   [p = probability_.data(), to = before_.data()](int v) { to[v] = as_before(p[v]); });
  }
  void forget_before() override { before_.clear(); }
  bool has_before() const override { return !before_.empty(); }

  std::vector<std::uint8_t> was_object(std::span<const Eigen::Vector3d> places_mm) const override {
    std::vector<std::uint8_t> was;
    was.reserve(places_mm.size());
    for (const Eigen::Vector3d& place : places_mm)
      was.push_back(before_[nearest_voxel(cells_, box_, place)] > kPreviousThreshold);
    return was;
  }
  std::vector<Before> before(std::span<const Eigen::Vector3d> places_mm) const override {
    const std::vector<std::uint8_t> was = was_object(places_mm);
    std::vector<Before> all;
    all.reserve(places_mm.size());
    for (std::size_t p = 0; p < places_mm.size(); ++p) {
      const std::vector<float> square = squared_distances(cells_, box_, places_mm.subspan(p, 1), run_);
      float least = unreached_mm * unreached_mm;
      for (std::size_t v = 0; v < before_.size(); ++v)
        if ((before_[v] > kPreviousThreshold) != (was[p] != 0)) least = std::min(least, square[v]);
      all.push_back({was[p] != 0, std::sqrt(least)});
    }
    return all;
  }

  void set_constraints(std::span<const Mark> marks, std::span<const Mark> others) override {
    known_ = constraint_mask(cells_, box_, finite_, marks, others);
  }

  double learn(std::span<const Mark> marks, std::span<const NewMarkBall> fresh, double reach_mm,
               double radius_mm) override {
    marks_.assign(marks.begin(), marks.end());
    fresh_.assign(fresh.begin(), fresh.end());
    scale_mm_ = {reach_mm, radius_mm};
    beta_ = sharpness_of(inner_difference(grid(), spacing_mm_, smoothed_, known_), settings_);
    coarse_.learn(prompts(), &progress());
    prior_.resize(known_.size());
    coarse_.interpolate(smoothed_, edge_of(beta_), prior_);
    return beta_;
  }

  Solved solve(double tolerance, bool further) override {
    const int n = grid().count();
    const ReportProgress report = [this](float part) { progress().advance(FieldPhase::Walker, part); };
    const RandomWalker::Report solved =
        further ? walker_->resume(tolerance, settings_.most_iterations, report) : begin_solution(tolerance, report);
    probability_.assign(walker_->field().begin(), walker_->field().end());
    const FromInner from_inner{{box_.size[0], box_.size[1], box_.size[2]}, walker_->field().data()};
    for_each_index(run_, n, [from_inner, known = known_.data(), to = probability_.data()](int v) {
      if (known[v] == Constraint::VolumeEdge) to[v] = from_inner(v);
    });
    smooth_by_least_spacing(probability_, grid(), spacing_mm_, settings_.field_smoothing, run_);
    for_each_index(run_, n, [known = known_.data(), to = probability_.data()](int v) {
      // Restores the values in marks after the smoothing.
      if (known[v] == Constraint::Inside || is_excluded(known[v])) to[v] = known[v] == Constraint::Inside;
    });
    object_ = object_of_field(probability_, known_, box_, run_);
    return {solved.iterations, solved.error, object_.around, object_.count, object_.border_share};
  }

  RefinedSurface refine_surface(const BandTerms& said) override {
    const double expected = expected_dice();
    put_work_away();
    refine_in_narrow_band(probability_, object_, known_, image_, before_, box_, spacing_mm_, said, settings_, run_);
    object_ = object_of_field(probability_, known_, box_, run_);
    return {{0, 0, object_.around, object_.count, object_.border_share}, expected};
  }

  std::span<const float> probability() const override { return probability_; }
  const FieldObject& object() const override { return object_; }
  std::span<const Constraint> known() const override { return known_; }
  std::vector<std::uint16_t> values(const FieldValue& value) const override {
    return field_values(object_.voxels, probability_, box_, cells_, value, run_);
  }
  const CoarsePrior* prior() const override { return &coarse_; }
  Prompts prompts() const override { return {marks_, known_, before_, fresh_, scale_mm_[0], scale_mm_[1]}; }
  std::size_t bytes() const override {
    const std::size_t bytes = finite_.size() + (image_.size() + smoothed_.size()) * 4 + known_.size() +
                              probability_.size() * 4 + object_.voxels.size() + before_.size() + prior_.size() +
                              solution_.size() * 2 + coarse_.bytes();
    return bytes + (walker_ ? walker_->bytes() : 0);
  }

 private:
  BoxGrid grid() const { return {box_.size}; }
  double expected_dice() const {
    const int n = static_cast<int>(probability_.size());
    const float* const p = probability_.data();
    const std::uint8_t* const is = object_.voxels.data();
    const double all = sum_over_indices(run_, n, [p](int v) { return p[v]; });
    const double right = sum_over_indices(run_, n, [p, is](int v) { return is[v] ? p[v] : 0.0f; });
    const double taken = sum_over_indices(run_, n, [is](int v) { return static_cast<float>(is[v]); });
    return taken > 0 ? 2 * right / (taken + all) : 0;
  }
  template <class T>
  void resample(const CellResampling& resampling, std::vector<T>& values) const {
    if (values.empty()) return;
    std::vector<T> resampled(box_.voxel_count());
    for_each_index(run_, static_cast<int>(resampled.size()),
                   [resampling, from = values.data(), to = resampled.data()](int v) { to[v] = resampling(v, from); });
    values = std::move(resampled);
  }
  /// What an update alone needs, two thirds of its memory, is given back; the solution is where the next one starts.
  void put_work_away() {
    if (!walker_) return;
    solution_.resize(walker_->field().size());
    for_each_index(run_, static_cast<int>(solution_.size()),
                   [from = walker_->field().data(), to = solution_.data()](int v) { to[v] = as_kept(from[v]); });
    walker_.reset();
    prior_ = {};
  }
  void take_work_out() {
    if (walker_) return;
    walker_ = std::make_unique<RandomWalker>(grid(), spacing_mm_, run_);
    for_each_index(run_, static_cast<int>(solution_.size()),
                   [from = solution_.data(), to = walker_->field().data()](int v) { to[v] = of_kept(from[v]); });
  }
  RandomWalker::Report begin_solution(double tolerance, const ReportProgress& report) {
    take_work_out();
    const int n = grid().count();
    set_edges(*walker_, spacing_mm_, smoothed_, finite_, beta_, settings_.prior_pull, run_);
    std::vector<std::uint8_t> held(n);
    coarse_.mark_open(known_, held);
    for_each_index(run_, n, [known = known_.data(), field = walker_->field().data(), held = held.data()](int v) {
      held[v] = is_dirichlet(known[v]) && held[v] == 0;
      if (held[v]) field[v] = known[v] == Constraint::Inside;
    });
    return walker_->solve(prior_, held, tolerance, settings_.most_iterations, report);
  }

  const Volume& volume_;
  RunJobs run_;
  EvidenceSettings settings_;
  std::array<double, 3> spacing_mm_{};  ///< of the cells
  double reach_of_box_mm_ = 0;          // with which the prior's blocks were made
  std::vector<std::uint8_t> finite_;    // 0 where the image is not
  std::vector<float> image_, smoothed_;
  std::vector<std::uint8_t> before_;  // field before the new marks, 1..255; 0: not known
  std::vector<Constraint> known_;
  std::vector<Mark> marks_;
  std::vector<NewMarkBall> fresh_;
  std::array<double, 2> scale_mm_{};
  double beta_ = 0;
  CoarsePrior coarse_;
  std::vector<std::uint8_t> prior_;       // P(object), 0..255
  std::unique_ptr<RandomWalker> walker_;  // while an update runs
  std::vector<std::uint16_t> solution_;   // of the walker, as kept between updates
  std::vector<float> probability_;
  FieldObject object_;
};

}  // namespace

std::size_t nearest_voxel(const VolumeGeometry& geometry, const VoxelBox& box, const Eigen::Vector3d& place_mm) {
  const Eigen::Vector3d index = geometry.index_from_world() * place_mm;
  std::array<int, 3> p;
  for (int a = 0; a < 3; ++a)
    p[a] = std::clamp(static_cast<int>(std::lround(index[a])) - box.first[a], 0, box.size[a] - 1);
  return box.offset(p[0], p[1], p[2]);
}

std::unique_ptr<FieldSolver> make_cpu_field_solver(const Volume& volume, const RunJobs& run,
                                                   const EvidenceSettings& settings) {
  return std::make_unique<CpuFieldSolver>(volume, run, settings);
}

}  // namespace simplexseg
