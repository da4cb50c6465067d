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

  void set_box(const CellSize& cell, const VoxelBox& box, double reach_mm) override {
    inner_->set_box(cell, box, reach_mm);
    cell_ = cell, box_ = box;
  }
  void keep_before() override { inner_->keep_before(); }
  void forget_before() override { inner_->forget_before(); }
  bool has_before() const override { return inner_->has_before(); }
  std::vector<std::uint8_t> was_object(std::span<const Eigen::Vector3d> places_mm) const override {
    return inner_->was_object(places_mm);
  }
  std::vector<Before> before(std::span<const Eigen::Vector3d> places_mm) const override {
    return inner_->before(places_mm);
  }
  void set_constraints(std::span<const Mark> marks, std::span<const Mark> others) override {
    inner_->set_constraints(marks, others);
  }
  double learn(std::span<const Mark> marks, std::span<const NewMarkBall> fresh, double reach_mm,
               double radius_mm) override {
    return inner_->learn(marks, fresh, reach_mm, radius_mm);
  }
  Solved solve(double tolerance, bool further) override { return inner_->solve(tolerance, further); }
  RefinedSurface refine_surface(const BandTerms& terms) override { return inner_->refine_surface(terms); }
  std::span<const float> probability() const override { return inner_->probability(); }
  const FieldObject& object() const override { return inner_->object(); }
  std::span<const Constraint> known() const override { return inner_->known(); }
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
