// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "study/reference_model.h"

namespace simplexseg {

/// Pose at which the acceleration is zero.
struct FixedPoint {
  Pose pose;
  double residual_mm = 0;     ///< largest |acceleration| of a vertex, divided by the sum of the weights
  double last_update_mm = 0;  ///< largest displacement of a vertex in the last update
  int iterations = 0;         ///< number of linear systems solved
  bool converged = false;     ///< whether the last update was below the tolerance, or the pose drifts
  /// True if some motion has no stiffness (similarities under shape memory alone): the residual is below ten times the
  /// tolerance and no longer decreases, and the updates only move the pose along that motion.
  bool drifts = false;
};
/// Finds a fixed point by Newton's method with a regularisation mu: (mu - J) dx = a, with J and a divided by the sum of
/// the weights. mu is reduced while the derivative predicts the result of a step well, and increased otherwise
/// (pseudo-transient continuation; C. T. Kelley, D. E. Keyes, "Convergence Analysis of Pseudo-Transient Continuation",
/// SIAM J. Numer. Anal. 35(2), 1998). The prediction is judged by the next, simplified correction (P. Deuflhard, Newton
/// Methods for Nonlinear Problems, Springer 2004). Far from a fixed point, the iteration follows the flow x' = a(x);
/// near a fixed point, it is Newton's method. Therefore `start` is best a settled pose of an engine. Linear systems are
/// solved by BiCGSTAB, preconditioned with a sparse LU of near_jacobian(). `max_iterations`: largest number of linear
/// systems.
FixedPoint find_fixed_point(const ReferenceModel& model, const Pose& start, double tolerance_mm = 1e-9,
                            int max_iterations = 100);

}  // namespace simplexseg
