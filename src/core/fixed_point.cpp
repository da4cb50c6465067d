// SPDX-License-Identifier: Apache-2.0
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>

#include "core/reference_model.h"

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

/// (mu - J / weight) dx = right, for one pose and one mu at a time.
class Systems {
 public:
  explicit Systems(const ReferenceModel& model) : model_(model) {}
  void set_pose(const Pose& pose) {
    near_ = model_.near_jacobian(pose) / -model_.weight_sum();
    if (!model_.depends_on_neighbours_alone()) full_ = model_.jacobian(pose) / -model_.weight_sum();
  }
  /// False when the matrix is singular to rounding.
  bool set_mu(double mu) {
    mu_ = mu;
    Eigen::SparseMatrix<double> regular = near_;
    for (Eigen::Index i = 0; i < regular.rows(); ++i) regular.coeffRef(i, i) += mu;
    regular.makeCompressed();
    // The pattern stays but for entries of attraction, which it has from the start.
    if (!analysed_) factors_.analyzePattern(regular);
    analysed_ = true;
    factors_.factorize(regular);
    if (factors_.info() != Eigen::Success) return false;
    if (full_.rows() == 0) return true;
    regular_ = full_;
    for (Eigen::Index i = 0; i < regular_.rows(); ++i) regular_.coeffRef(i, i) += mu;
    solver_.preconditioner().factors = &factors_;
    solver_.compute(regular_);
    return true;
  }
  Pose solve(const Pose& right, double tolerance) {
    const Eigen::Map<const Eigen::VectorXd> flat(right.data(), right.size());
    Eigen::VectorXd solution;
    if (full_.rows() == 0) {
      solution = factors_.solve(flat);
    } else {
      solver_.setTolerance(tolerance);
      solver_.setMaxIterations(500);
      solution = solver_.solve(flat);
    }
    return Eigen::Map<const Pose>(solution.data(), 3, right.cols());
  }

 private:
  const ReferenceModel& model_;
  ReferenceModel::Matrix near_, full_, regular_;
  Factors factors_;
  Eigen::BiCGSTAB<ReferenceModel::Matrix, Factored> solver_;
  double mu_ = 0;
  bool analysed_ = false;
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
  double mu = 1e-2;  // in shares of the weight sum
  double before = INFINITY;
  Systems systems(model);
  systems.set_pose(start);
  while (result.iterations < most_iterations && mu < kMost) {
    ++result.iterations;
    double miss = INFINITY;
    Pose dx, there, correction;
    if (systems.set_mu(mu)) {
      dx = systems.solve(a, 1e-6);
      there = result.pose + dx;
      const Pose next = there.allFinite() ? Pose(model.acceleration(there) / weight) : there;
      if (next.allFinite()) {
        // The derivative promises mu dx as what is left; what is more than that is a failure of linearity.
        correction = systems.solve(next - mu * dx, 1e-2);
        miss = correction.norm() / dx.norm();
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
