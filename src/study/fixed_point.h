// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "study/reference_model.h"

namespace simplexseg {

/// A pose at which the acceleration vanishes.
struct FixedPoint {
  Pose pose;
  double residual_mm = 0;     ///< largest |acceleration| of a vertex over the sum of weights
  double last_update_mm = 0;  ///< largest over the vertices
  int iterations = 0;         ///< linear systems solved
  bool converged = false;     ///< the last update was below the tolerance, or the pose drifts
  /// Some motion costs nothing (similarities under shape memory alone): the residual, below ten times the tolerance, no
  /// longer falls, and updates only move the pose along that motion.
  bool drifts = false;
};
/// Newton's method with a regularisation mu: (mu - J) dx = a. mu falls as long as a step does what the derivative
/// promises and rises where it does not (pseudo-transient continuation; C. T. Kelley, D. E. Keyes, "Convergence
/// Analysis of Pseudo-Transient Continuation", SIAM J. Numer. Anal. 35(2), 1998), which is judged by the next,
/// simplified correction (P. Deuflhard, Newton Methods for Nonlinear Problems, Springer 2004). From far away it follows
/// the flow x' = a(x), from near it is Newton's method, so start near: from where an engine came to rest. Linear
/// systems are solved by sparse LU; with smoothing that keeps curvature, by BiCGSTAB over the LU of near_jacobian.
FixedPoint find_fixed_point(const ReferenceModel& model, const Pose& start, double tolerance_mm = 1e-9,
                            int most_iterations = 100);

}  // namespace simplexseg
