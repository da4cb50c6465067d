// SPDX-License-Identifier: Apache-2.0
// Scenes whose course or whose end is known exactly: what integrators and solvers are measured against.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mesh/simplex_mesh.h"
#include "study/reference_model.h"

namespace simplexseg {

struct AnalyticScene {
  std::string name;
  SimplexMesh mesh;                        ///< pose at time 0, at rest
  ForceParameters forces;                  ///< no image force acts
  std::vector<Eigen::Vector3d> points_mm;  ///< attraction points of the mesh
  Pose fixed_point;
  /// Pose at time t (also before 0) under x'' = a(x) - c x' from rest at time 0, c >= 0 in units of 1/time; empty where
  /// no closed form is known. A step of dt with the damping g = c dt follows it.
  std::function<Pose(double t, double c)> exact;
};

/// One vertex pulled to a point beside it by attraction of order 0: x'' = -k (x - C) - c x'. All others stay.
AnalyticScene oscillator_scene(double stiffness = 1);
/// A regular dodecahedron (V = 20) under smoothing without evenness and curvature. The mean of a vertex's neighbours is
/// sqrt(5)/3 of it, so it shrinks and swells as r'' = -k (1 - sqrt(5)/3) r - c r'.
AnalyticScene sphere_relaxation_scene(double stiffness = 1);
/// A sphere of 20 * 4^level vertices under the same smoothing (weight k) with attraction points of order 0 beside every
/// `every`-th vertex (weight q): a mesh of springs. Its fixed point is that of (k/3) sum_j (x_j - x_i) + q_i (C_i -
/// x_i) = 0, by sparse LDLT in double.
AnalyticScene spring_mesh_scene(int level = 3, int every = 10, double stiffness = 1, double pull = 0.5);

/// The solution of x'' = -k x - c x' with x(0) = 1, x'(0) = 0.
double damped_oscillation(double stiffness, double damping_rate, double t);

/// Slope of log error over log dt (least squares): the order of a method. As many errors as timesteps, at least two.
double measured_order(std::span<const double> timesteps, std::span<const double> errors);

}  // namespace simplexseg
