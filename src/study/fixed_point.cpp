// SPDX-License-Identifier: Apache-2.0
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "study/fixed_point.h"

namespace simplexseg {
namespace {

double largest(const Pose& x) { return x.colwise().norm().maxCoeff(); }

using Factors = Eigen::SparseLU<Eigen::SparseMatrix<double>>;
/// What Eigen's solvers want a preconditioner to be.
struct Factored {
  const Factors* factors = nullptr;
  template <class M>
  Factored& analyzePattern(const M&) {
    return *this;
  }
  template <class M>
  Factored& factorize(const M&) {
    return *this;
  }
  template <class M>
  Factored& compute(const M&) {
    return *this;
  }
  template <class Right>
  Eigen::VectorXd solve(const Right& right) const {
    return factors->solve(Eigen::VectorXd(right));
  }
  Eigen::ComputationInfo info() const { return Eigen::Success; }
};

/// (mu - J / weight) dx = right, for one pose and one mu at a time: BiCGSTAB over the factors of an earlier
/// near_jacobian, which are made anew when it takes long.
class Systems {
 public:
  explicit Systems(const ReferenceModel& model) : model_(model) {}
  void set_pose(const Pose& pose) {
    pose_ = pose;
    matrix_ = model_.jacobian(pose) / -model_.weight_sum();
  }
  void set_mu(double mu) {
    mu_ = mu;
    regular_ = matrix_;
    add_to_diagonal(regular_);
    fresh_ = false;
    solver_.preconditioner().factors = &factors_;
    solver_.compute(regular_);
  }
  /// Empty when the matrix is singular to rounding.
  std::optional<Pose> solve(const Pose& right, double tolerance) {
    constexpr int kQuick = 12, kMost = 500;
    const Eigen::Map<const Eigen::VectorXd> flat(right.data(), right.size());
    solver_.setTolerance(tolerance);
    Eigen::VectorXd solution;
    if (!fresh_ && analysed_) {
      solver_.setMaxIterations(kQuick);
      solution = solver_.solve(flat);
    }
    if (solution.size() == 0 || solver_.info() != Eigen::Success || !solution.allFinite()) {
      if (!fresh_ && !factorise()) return std::nullopt;
      solver_.setMaxIterations(kMost);
      solution = solver_.solve(flat);
    }
    return Pose(Eigen::Map<const Pose>(solution.data(), 3, right.cols()));
  }

 private:
  template <class Matrix>
  void add_to_diagonal(Matrix& matrix) const {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) matrix.coeffRef(i, i) += mu_;
  }
  bool factorise() {
    Eigen::SparseMatrix<double> regular = model_.near_jacobian(pose_) / -model_.weight_sum();
    add_to_diagonal(regular);
    regular.makeCompressed();
    if (!analysed_) factors_.analyzePattern(regular);  // the pattern stays
    analysed_ = true;
    factors_.factorize(regular);
    fresh_ = factors_.info() == Eigen::Success;
    return fresh_;
  }

  const ReferenceModel& model_;
  Pose pose_;
  ReferenceModel::Matrix matrix_, regular_;
  Factors factors_;
  Eigen::BiCGSTAB<ReferenceModel::Matrix, Factored> solver_;
  double mu_ = 0;
  bool analysed_ = false, fresh_ = false;  // fresh: the factors are those of the present system
};

}  // namespace

FixedPoint find_fixed_point(const ReferenceModel& model, const Pose& start, double tolerance_mm, int most_iterations) {
  constexpr double kLeast = 1e-9, kMost = 1e6;
  const double weight = model.weight_sum();
  FixedPoint result;
  result.pose = start;
  if (!(weight > 0) || start.cols() == 0) {
    result.converged = true;
    return result;
  }
  Pose a = model.acceleration(start) / weight;
  const double edge = (start.col(0) - start.col(model.neighbours()[0][0])).norm();
  double mu = std::clamp(largest(a) / edge, kLeast, 1e-2);  // in shares of the weight sum; the nearer, the less
  double before = INFINITY;
  Systems systems(model);
  systems.set_pose(start);
  while (result.iterations < most_iterations && mu < kMost) {
    ++result.iterations;
    double miss = INFINITY;
    Pose dx, there, correction;
    systems.set_mu(mu);
    if (const std::optional<Pose> step = systems.solve(a, 1e-6)) {
      dx = *step;
      there = result.pose + dx;
      const Pose next = there.allFinite() ? Pose(model.acceleration(there) / weight) : there;
      if (next.allFinite()) {
        // The derivative promises mu dx as what is left; what is more than that is a failure of linearity.
        const std::optional<Pose> more = systems.solve(next - mu * dx, 1e-2);
        if (more) correction = *more, miss = correction.norm() / dx.norm();
      }
    }
    const double update = miss < INFINITY ? largest(dx) : INFINITY;
    if (!(miss < 0.5) && !(update < tolerance_mm)) {
      mu *= 4;
      continue;
    }
    result.pose = update < tolerance_mm ? there : Pose(there + correction);
    result.last_update_mm = update;
    a = model.acceleration(result.pose) / weight;
    const double residual = largest(a);
    result.drifts = residual > 0.3 * before && residual < 10 * tolerance_mm && update > tolerance_mm;
    result.converged = (update < tolerance_mm && mu <= 1e-6) || result.drifts;
    if (result.converged) break;
    before = residual;
    mu = std::max(mu * (miss < 0.05 ? 0.1 : miss < 0.2 ? 0.3 : 1.0), kLeast);
    systems.set_pose(result.pose);
  }
  result.residual_mm = largest(a);
  return result;
}

}  // namespace simplexseg
