// SPDX-License-Identifier: Apache-2.0
#include "study/stability_limits.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"
#include "study/trials.h"

namespace simplexseg {
namespace {

constexpr float kWeight = 0.8f;
constexpr double kRadius = 20;

/// Hexagonal mesh on a torus with a tube so thin that all edges of a vertex are nearly parallel to the tube: one in one
/// direction, two in the other. The single edge is longer by the factor 2^(1/(1+a)), for which smoothing with evenness
/// a is in equilibrium along the tube.
SimplexMesh stretched_tube(int along, int around, double evenness) {
  // A long edge connects vertex A(u, v) to B(u, v); two short edges connect B(u, v) to A(u+1, v) and A(u+1, v+1).
  SimplexMesh mesh;
  const double ratio = std::pow(2.0, 1 / (1 + evenness)), cell = 2 * std::numbers::pi / along;
  const double tube_radius = 0.02 * cell * kRadius * around / (2 * std::numbers::pi);
  const auto a = [=](int u, int v) { return 2 * ((u + along) % along * around + (v + around) % around); };
  for (int u = 0; u < along; ++u)
    for (int v = 0; v < around; ++v)
      for (int b = 0; b < 2; ++b) {
        const double length = cell * (u + b * ratio / (1 + ratio));
        // Each row is rotated by half a cell, which makes the two short edges equal; the rotations of all `along` rows
        // add up to whole turns.
        const double turn = 2 * std::numbers::pi / around * (v - 0.5 * u);
        const double radius = kRadius + tube_radius * std::cos(turn);
        mesh.positions.push_back(
            Eigen::Vector3d(radius * std::cos(length), radius * std::sin(length), tube_radius * std::sin(turn))
                .cast<float>());
        if (b == 0)
          mesh.neighbours.push_back({a(u, v) + 1, a(u - 1, v) + 1, a(u - 1, v - 1) + 1});
        else
          mesh.neighbours.push_back({a(u, v), a(u + 1, v), a(u + 1, v + 1)});
      }
  if (measure(mesh).volume_mm3 < 0)
    for (auto& n : mesh.neighbours) std::swap(n[1], n[2]);
  return mesh;
}

/// Root mean square over the vertices of the component of the smoothing force along the first edge, for weight 1.
double smoothing_along_edges(const SimplexMesh& mesh, double evenness) {
  double sum = 0;
  for (int i = 0; i < mesh.vertex_count(); ++i) {
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), first = force;
    double weights = 0;
    for (int slot = 0; slot < 3; ++slot) {
      const Eigen::Vector3d edge = (mesh.positions[mesh.neighbours[i][slot]] - mesh.positions[i]).cast<double>();
      const double weight = std::pow(edge.norm(), evenness);
      force += weight * edge, weights += weight;
      if (slot == 0) first = edge.normalized();
    }
    sum += std::pow(force.dot(first) / weights, 2);
  }
  return std::sqrt(sum / mesh.vertex_count());
}

LimitProblem even_smoothing(float evenness) {
  LimitProblem problem;
  problem.name = "smoothing, evenness " + std::to_string(static_cast<int>(evenness));
  problem.forces = forces_with(
      {{"smoothing", "weight", kWeight}, {"smoothing", "evenness", evenness}, {"smoothing", "curvature", 0}});
  problem.mesh = stretched_tube(60, 6, evenness);
  // The fastest mode moves all vertices A against all vertices B.
  const std::vector<Eigen::Vector3f> equilibrium = problem.mesh.positions;
  for (int i = 0; i < problem.mesh.vertex_count(); ++i)
    problem.mesh.positions[i] += 0.0003f * (equilibrium[problem.mesh.neighbours[i][0]] - equilibrium[i]);
  problem.deviation = [evenness](const SimplexMesh& mesh) { return smoothing_along_edges(mesh, evenness); };
  return problem;
}

LimitProblem laplacian() {
  LimitProblem problem;
  problem.name = "smoothing, evenness 0";
  // The force is linear and its fixed point is a single point; the mesh is noise around this point.
  problem.mesh = add_noise(make_sphere({0, 0, 0}, 1, 3), 1);
  const SimplexMesh sphere = make_sphere({0, 0, 0}, 1, 3);
  for (int i = 0; i < sphere.vertex_count(); ++i) problem.mesh.positions[i] -= sphere.positions[i];
  problem.forces =
      forces_with({{"smoothing", "weight", kWeight}, {"smoothing", "evenness", 0}, {"smoothing", "curvature", 0}});
  problem.deviation = [](const SimplexMesh& mesh) {
    double sum = 0;
    for (const Eigen::Vector3f& p : mesh.positions) sum += p.cast<double>().squaredNorm();
    return std::sqrt(sum);
  };
  return problem;
}

LimitProblem shape_memory() {
  LimitProblem problem;
  problem.name = "shape_memory";
  const SimplexMesh reference = make_sphere({0, 0, 0}, kRadius, 2);
  problem.shape = shape_reference_of(reference);
  problem.mesh = add_noise(reference, 0.01);
  problem.forces = forces_with({{"shape_memory", "weight", kWeight}, {"shape_memory", "scaling", 0}});
  // Rigid motions have no stiffness, so the deviation is measured in elevations.
  problem.deviation = [shape = problem.shape](const SimplexMesh& mesh) {
    double sum = 0;
    for (int i = 0; i < mesh.vertex_count(); ++i)
      sum += std::pow(vertex_geometry(mesh, i).elevation_mm - shape[i].z, 2);
    return std::sqrt(sum);
  };
  return problem;
}

/// Image force with a fixed target 0.01 mm above every vertex.
LimitProblem image_force(const ForceInfo& force) {
  LimitProblem problem;
  problem.name = force.name;
  problem.mesh = make_sphere({0, 0, 0}, kRadius, 1);
  problem.forces = forces_with({{force.name, "weight", kWeight}});
  if (find_parameter(force.parameters, "pull") >= 0) set_value(problem.forces, {force.name, "pull", 0});  // 0: no bound
  problem.target_force = force.id;
  for (const Eigen::Vector3f& p : problem.mesh.positions) {
    const Eigen::Vector3f target = 1.0005f * p;
    problem.targets.push_back({target[0], target[1], target[2], 1});
  }
  problem.deviation = [](const SimplexMesh& mesh) {
    double sum = 0;
    for (const Eigen::Vector3f& p : mesh.positions) sum += std::pow(p.cast<double>().norm() - 1.0005 * kRadius, 2);
    return std::sqrt(sum);
  };
  return problem;
}

/// Attraction of one vertex to a point at a distance of 0.01 mm.
LimitProblem attraction() {
  LimitProblem problem;
  problem.name = "attraction";
  problem.mesh = make_sphere({0, 0, 0}, kRadius, 2);
  problem.forces = forces_with({{"attraction", "weight", kWeight}, {"attraction", "order", 0}});
  const Eigen::Vector3d point = 1.0005 * problem.mesh.positions[7].cast<double>();
  problem.points = {{0, point}};
  problem.deviation = [point](const SimplexMesh& mesh) { return (mesh.positions[7].cast<double>() - point).norm(); };
  return problem;
}

}  // namespace

std::vector<LimitProblem> limit_problems() {
  std::vector<LimitProblem> problems{laplacian()};
  for (const float evenness : {1.0f, 2.0f, 4.0f, 6.0f}) problems.push_back(even_smoothing(evenness));
  problems.push_back(shape_memory());
  for (const ForceInfo& force : force_list())
    if (force.targets != nullptr) problems.push_back(image_force(force));
  problems.push_back(attraction());
  return problems;
}

double predicted_limit(const LimitProblem& problem, double damping) {
  return stable_timestep(stiffness_bound(problem.forces, problem.shape), static_cast<float>(damping));
}

bool deviation_grows(const LimitProblem& problem, double damping, double timestep, const EngineFactory& make_engine) {
  const std::unique_ptr<Engine> engine = make_engine();
  SimulationParameters simulation = usual_settings();
  simulation.solver_choice = static_cast<float>(Solver::Verlet), simulation.limit_timestep = 0;
  simulation.timestep = static_cast<float>(timestep), simulation.damping = static_cast<float>(damping);
  simulation.refresh_interval = 50;
  EngineMesh loaded;
  loaded.positions = loaded.previous = problem.mesh.positions, loaded.neighbours = problem.mesh.neighbours;
  loaded.shape = problem.shape, loaded.parameters = problem.forces;
  engine->load(std::span(&loaded, 1), simulation);
  if (problem.target_force) engine->set_fixed_targets(0, *problem.target_force, problem.targets);
  engine->set_points(problem.points);
  SimplexMesh mesh = problem.mesh;
  std::vector<Eigen::Vector3f> previous(mesh.positions.size());
  const double before = problem.deviation(mesh);
  for (int batch = 0; batch < 12; ++batch) {
    const StepOutcome outcome = engine->step(50);
    if (outcome.failure || !outcome.cuts.empty()) return true;
    engine->read(0, mesh.positions, previous);
    const double now = problem.deviation(mesh);
    if (!(now < 20 * before)) return true;
    if (now < 1e-2 * before) return false;
  }
  return false;
}

double measured_limit(const LimitProblem& problem, double damping, const EngineFactory& make_engine) {
  const auto grows = [&](double timestep) { return deviation_grows(problem, damping, timestep, make_engine); };
  const double predicted = predicted_limit(problem, damping);
  double stable = 0.5 * predicted, unstable = 2 * predicted;
  if (grows(stable)) return 0;
  if (!grows(unstable)) {
    if (!grows(100 * predicted)) return INFINITY;
    unstable = 100 * predicted;
  }
  while (unstable / stable > 1.005) {
    const double middle = std::sqrt(stable * unstable);
    (grows(middle) ? unstable : stable) = middle;
  }
  return stable;
}

bool StabilityLimit::as_predicted() const { return std::abs(std::pow(predicted / measured, 2) - 1) < 0.05; }

std::vector<StabilityLimit> stability_limits(const EngineFactory& make_engine) {
  std::vector<StabilityLimit> limits;
  for (const LimitProblem& problem : limit_problems())
    for (const double damping : kLimitDampings)
      limits.push_back(
          {problem.name, damping, predicted_limit(problem, damping), measured_limit(problem, damping, make_engine)});
  return limits;
}

}  // namespace simplexseg
