// SPDX-License-Identifier: Apache-2.0
// Scenes with an exactly known motion or fixed point, as references for integrators and solvers.
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
  SimplexMesh mesh;                        ///< pose at time 0, with zero velocity
  ForceParameters forces;                  ///< forces of the mesh; no image force acts
  std::vector<Eigen::Vector3d> points_mm;  ///< attraction points of the mesh
  Pose fixed_point;
  /// Pose at time t (also t < 0) under x'' = a(x) - c x' with zero velocity at time 0, c >= 0 in units of 1/time; empty
  /// if there is no closed form. A step dt with damping g = c dt approximates the motion.
  std::function<Pose(double t, double c)> exact;
};

/// One vertex, attracted to a nearby point C with order 0: x'' = -k (x - C) - c x', k = `stiffness`. No force acts on
/// the other vertices.
AnalyticScene oscillator_scene(double stiffness = 1);
/// Regular dodecahedron (V = 20) under smoothing of weight k = `stiffness`, with evenness and curvature 0. The mean of
/// a vertex's neighbours is sqrt(5)/3 times the vertex, so the radius follows r'' = -k (1 - sqrt(5)/3) r - c r'.
AnalyticScene sphere_relaxation_scene(double stiffness = 1);
/// Spring network: a sphere of 20 * 4^level vertices under the same smoothing (weight k = `stiffness`), with an
/// attraction point of order 0 near every `every`-th vertex (weight q = `pull`). The fixed point is the solution of
/// (k/3) sum_j (x_j - x_i) + q_i (C_i - x_i) = 0, computed by sparse LDLT in double; q_i is 0 for vertices without a
/// point.
AnalyticScene spring_mesh_scene(int level = 3, int every = 10, double stiffness = 1, double pull = 0.5);

/// Solution of x'' = -k x - c x' with x(0) = 1, x'(0) = 0, k = `stiffness` and c = `damping_rate`.
double damped_oscillation(double stiffness, double damping_rate, double t);

/// Order of convergence of a method: slope of log error over log timestep (least squares). One error per timestep, at
/// least two.
double measured_order(std::span<const double> timesteps, std::span<const double> errors);

}  // namespace simplexseg
