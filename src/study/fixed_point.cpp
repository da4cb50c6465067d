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
/// Sparse LU as a preconditioner, with the interface that Eigen's solvers require.
struct LuPreconditioner {
  const Factors* factors = nullptr;
  template <class M>
  LuPreconditioner& analyzePattern(const M&) {
    return *this;
  }
  template <class M>
  LuPreconditioner& factorize(const M&) {
    return *this;
  }
  template <class M>
  LuPreconditioner& compute(const M&) {
    return *this;
  }
  template <class Right>
  Eigen::VectorXd solve(const Right& right) const {
    return factors->solve(Eigen::VectorXd(right));
  }
  Eigen::ComputationInfo info() const { return Eigen::Success; }
};

/// Solver of (mu - J / weight) dx = right for one pose and one mu; weight: sum of the weights. BiCGSTAB, preconditioned
/// with the factors of an earlier near_jacobian(), which are recomputed when BiCGSTAB converges slowly.
class LinearSystems {
 public:
  explicit LinearSystems(const ReferenceModel& model) : model_(model) {}
  void set_pose(const Pose& pose) {
    pose_ = pose;
    matrix_ = model_.jacobian(pose) / -model_.weight_sum();
  }
  void set_mu(double mu) {
    mu_ = mu;
    regular_ = matrix_;
    add_to_diagonal(regular_);
    factors_current_ = false;
    solver_.preconditioner().factors = &factors_;
    solver_.compute(regular_);
  }
  /// Solution for the right-hand side `right`, to a relative residual `tolerance`; empty if the factorisation fails.
  std::optional<Pose> solve(const Pose& right, double tolerance) {
    constexpr int kQuickIterations = 12, kMaxIterations = 500;
    const Eigen::Map<const Eigen::VectorXd> flat(right.data(), right.size());
    solver_.setTolerance(tolerance);
    Eigen::VectorXd solution;
    if (!factors_current_ && analysed_) {
      solver_.setMaxIterations(kQuickIterations);
      solution = solver_.solve(flat);
    }
    if (solution.size() == 0 || solver_.info() != Eigen::Success || !solution.allFinite()) {
      if (!factors_current_ && !factorise()) return std::nullopt;
      solver_.setMaxIterations(kMaxIterations);
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
    if (!analysed_) factors_.analyzePattern(regular);  // the pattern does not change
    analysed_ = true;
    factors_.factorize(regular);
    factors_current_ = factors_.info() == Eigen::Success;
    return factors_current_;
  }

  const ReferenceModel& model_;
  Pose pose_;
  ReferenceModel::Matrix matrix_, regular_;
  Factors factors_;
  Eigen::BiCGSTAB<ReferenceModel::Matrix, LuPreconditioner> solver_;
  double mu_ = 0;
  bool analysed_ = false, factors_current_ = false;  // factors_current_: whether the factors fit the current system
};

}  // namespace

FixedPoint find_fixed_point(const ReferenceModel& model, const Pose& start, double tolerance_mm, int max_iterations) {
  constexpr double kMinMu = 1e-9, kMaxMu = 1e6;
  const double weight = model.weight_sum();
  FixedPoint result;
  result.pose = start;
  if (!(weight > 0) || start.cols() == 0) {
    result.converged = true;
    return result;
  }
  Pose a = model.acceleration(start) / weight;
  const double edge = (start.col(0) - start.col(model.neighbours()[0][0])).norm();
  double mu = std::clamp(largest(a) / edge, kMinMu, 1e-2);  // relative to the sum of the weights
  double before = INFINITY;
  LinearSystems systems(model);
  systems.set_pose(start);
  while (result.iterations < max_iterations && mu < kMaxMu) {
    ++result.iterations;
    double mismatch = INFINITY;
    Pose dx, candidate, correction;
    systems.set_mu(mu);
    if (const std::optional<Pose> step = systems.solve(a, 1e-6)) {
      dx = *step;
      candidate = result.pose + dx;
      const Pose next = candidate.allFinite() ? Pose(model.acceleration(candidate) / weight) : candidate;
      if (next.allFinite()) {
        // The linear model predicts the residual mu dx; the difference from it measures the nonlinearity.
        const std::optional<Pose> second = systems.solve(next - mu * dx, 1e-2);
        if (second) correction = *second, mismatch = correction.norm() / dx.norm();
      }
    }
    const double update = mismatch < INFINITY ? largest(dx) : INFINITY;
    if (!(mismatch < 0.5) && !(update < tolerance_mm)) {
      mu *= 4;
      continue;
    }
    result.pose = update < tolerance_mm ? candidate : Pose(candidate + correction);
    result.last_update_mm = update;
    a = model.acceleration(result.pose) / weight;
    const double residual = largest(a);
    result.drifts = residual > 0.3 * before && residual < 10 * tolerance_mm && update > tolerance_mm;
    result.converged = (update < tolerance_mm && mu <= 1e-6) || result.drifts;
    if (result.converged) break;
    before = residual;
    mu = std::max(mu * (mismatch < 0.05 ? 0.1 : mismatch < 0.2 ? 0.3 : 1.0), kMinMu);
    systems.set_pose(result.pose);
  }
  result.residual_mm = largest(a);
  return result;
}

}  // namespace simplexseg
