// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "field/field_solver.h"

namespace simplexseg {

/// Solver of a field that calls another one; base of solvers that measure.
class ForwardingSolver : public FieldSolver {
 public:
  explicit ForwardingSolver(std::unique_ptr<FieldSolver> inner) : inner_(std::move(inner)) {}

  void set_box(const CellSize& cell, const VoxelBox& box, double scale_mm) override {
    inner_->set_box(cell, box, scale_mm);
    cell_ = cell, box_ = box;
  }
  Solved restore(std::span<const float> probability) override { return inner_->restore(probability); }
  void store_previous(bool only_object) override { inner_->store_previous(only_object); }
  void discard_previous() override { inner_->discard_previous(); }
  bool has_previous() const override { return inner_->has_previous(); }
  std::vector<std::uint8_t> previous_object(std::span<const Eigen::Vector3d> places_mm) const override {
    return inner_->previous_object(places_mm);
  }
  std::vector<PreviousSide> previous_sides(std::span<const Eigen::Vector3d> places_mm) const override {
    return inner_->previous_sides(places_mm);
  }
  void set_constraints(std::span<const Mark> marks, std::span<const Mark> others, const BoxSides& open) override {
    inner_->set_constraints(marks, others, open);
  }
  void set_shape_prior(std::shared_ptr<const ShapePrior> prior) override { inner_->set_shape_prior(std::move(prior)); }
  double compute_prior(std::span<const Mark> marks, std::span<const NewMarkBall> new_balls, double scale_mm,
                       double radius_mm) override {
    return inner_->compute_prior(marks, new_balls, scale_mm, radius_mm);
  }
  Solved solve(double tolerance, bool resume) override { return inner_->solve(tolerance, resume); }
  RefinedSurface refine_surface(const BandTerms& terms) override { return inner_->refine_surface(terms); }
  Solved damp_far_change(std::span<const NewMarkBall> new_balls, double far_depths, double share) override {
    return inner_->damp_far_change(new_balls, far_depths, share);
  }
  std::span<const float> probability() const override { return inner_->probability(); }
  const FieldObject& object() const override { return inner_->object(); }
  std::span<const Constraint> constraints() const override { return inner_->constraints(); }
  std::span<const float> smoothed_image() const override { return inner_->smoothed_image(); }
  std::vector<std::uint16_t> values(const FieldValue& value) const override { return inner_->values(value); }
  void record_features(bool record) override { inner_->record_features(record); }
  const PriorFeatures& features() const override { return inner_->features(); }
  std::size_t bytes() const override { return inner_->bytes(); }

 protected:
  FieldSolver& inner() const { return *inner_; }

 private:
  std::unique_ptr<FieldSolver> inner_;
};

}  // namespace simplexseg
