// SPDX-License-Identifier: Apache-2.0
#include "study/analytic_scenes.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <complex>

#include "forces/force_list.h"

namespace simplexseg {
namespace {

constexpr double kRadiusMm = 10;

ForceParameters no_forces() {
  ForceParameters forces = default_force_parameters();
  for (auto& values : forces.values) values[0] = 0;
  return forces;
}
void add_plain_smoothing(ForceParameters& forces, double weight) {
  auto& smoothing = forces.values[static_cast<int>(ForceId::Smoothing)];
  smoothing[SmoothingForce::weight] = static_cast<float>(weight);
  smoothing[SmoothingForce::evenness] = smoothing[SmoothingForce::curvature] = 0;
}
void add_point_attraction(ForceParameters& forces, double weight) {
  auto& attraction = forces.values[static_cast<int>(ForceId::Attraction)];
  attraction[AttractionForce::weight] = static_cast<float>(weight);
  attraction[AttractionForce::order] = 0;
}

}  // namespace

double damped_oscillation(double stiffness, double damping_rate, double t) {
  // Solution from the roots of s^2 + c s + k; for a double root, x = (1 + c t / 2) exp(-c t / 2).
  const double half = damping_rate / 2;
  const std::complex<double> root = std::sqrt(std::complex<double>(half * half - stiffness));
  if (std::abs(root) < 1e-9) return (1 + half * t) * std::exp(-half * t);
  const std::complex<double> s1 = -half + root, s2 = -half - root;
  return ((s1 * std::exp(s2 * t) - s2 * std::exp(s1 * t)) / (s1 - s2)).real();
}

AnalyticScene oscillator_scene(double stiffness) {
  AnalyticScene scene{"oscillator", make_sphere({0, 0, 0}, kRadiusMm, 0), no_forces(), {}, {}, {}};
  add_point_attraction(scene.forces, stiffness);
  const Eigen::Vector3d point = scene.mesh.positions[0].cast<double>();
  scene.points_mm = {point};
  scene.fixed_point = pose_of(scene.mesh.positions);
  scene.mesh.positions[0] *= 1.2f;  // outwards, so that this vertex remains the nearest to the point
  const Eigen::Vector3d start = scene.mesh.positions[0].cast<double>() - point;
  const double k = scene.forces.weight(ForceId::Attraction);
  scene.exact = [settled = scene.fixed_point, point, start, k](double t, double c) {
    Pose pose = settled;
    pose.col(0) = point + damped_oscillation(k, c, t) * start;
    return pose;
  };
  return scene;
}

AnalyticScene sphere_relaxation_scene(double stiffness) {
  AnalyticScene scene{"sphere relaxation", make_sphere({0, 0, 0}, kRadiusMm, 0), no_forces(), {}, {}, {}};
  add_plain_smoothing(scene.forces, stiffness);
  const Pose start = pose_of(scene.mesh.positions);
  scene.fixed_point = Pose::Zero(3, start.cols());
  const double k = scene.forces.weight(ForceId::Smoothing) * (1 - std::sqrt(5.0) / 3);
  scene.exact = [start, k](double t, double c) { return Pose(damped_oscillation(k, c, t) * start); };
  return scene;
}

AnalyticScene spring_mesh_scene(int level, int every, double stiffness, double pull) {
  AnalyticScene scene{"spring mesh", make_sphere({0, 0, 0}, kRadiusMm, level), no_forces(), {}, {}, {}};
  add_plain_smoothing(scene.forces, stiffness);
  add_point_attraction(scene.forces, pull);
  const double k = scene.forces.weight(ForceId::Smoothing), q = scene.forces.weight(ForceId::Attraction);
  const int vertices = scene.mesh.vertex_count();
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(vertices, 3);
  for (int i = 0; i < vertices; ++i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const bool pulled = i % every == 0;
    entries.emplace_back(i, i, k + (pulled ? q : 0));
    for (int j : scene.mesh.neighbours[at]) entries.emplace_back(i, j, -k / 3);
    if (!pulled) continue;
    // The points lie alternately outside and inside the sphere, so close that the nearest vertex remains the same.
    const double factor = i / every % 2 == 0 ? 1.02 : 0.99;
    scene.points_mm.push_back(factor * scene.mesh.positions[at].cast<double>());
    right.row(i) = q * scene.points_mm.back().transpose();
  }
  Eigen::SparseMatrix<double> matrix(vertices, vertices);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(matrix);
  const Eigen::MatrixX3d solution = factors.solve(right);
  scene.fixed_point = solution.transpose();
  return scene;
}

double measured_order(std::span<const double> timesteps, std::span<const double> errors) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t k = 0; k < timesteps.size(); ++k) {
    const double u = std::log(timesteps[k]), v = std::log(errors[k]);
    n += 1, x += u, y += v, xx += u * u, xy += u * v;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

}  // namespace simplexseg
