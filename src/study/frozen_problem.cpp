// SPDX-License-Identifier: Apache-2.0
#include "study/frozen_problem.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/number_text.h"
#include "forces/force_list.h"
#include "mesh/mesh_geometry.h"
#include "session/engine_scene.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"
#include "step/step_needs.h"
#include "study/fixed_point.h"
#include "study/trials.h"

namespace simplexseg {
namespace {

constexpr double kToleranceMm = 1e-9;
constexpr int kMaxStepsToTargets = 2000, kStepsBetweenPolls = 10;

Pose normals_of(const SimplexMesh& mesh) {
  Pose normals(3, mesh.vertex_count());
  for (int i = 0; i < mesh.vertex_count(); ++i) normals.col(i) = vertex_geometry(mesh, i).normal;
  return normals;
}

PoseError rms(const std::vector<FrozenMesh>& meshes, const std::function<Pose(std::size_t)>& pose_of_mesh) {
  double whole = 0, normal = 0, count = 0;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const Pose deviation = pose_of_mesh(k) - meshes[k].end;
    whole += deviation.squaredNorm();
    normal += deviation.cwiseProduct(meshes[k].end_normals).colwise().sum().squaredNorm();
    count += static_cast<double>(deviation.cols());
  }
  return {std::sqrt(whole / count), std::sqrt(normal / count)};
}

/// Computes the normals at the fixed point and the initial error; `end` of each mesh must be set.
void set_normals_and_start_error(FrozenProblem& problem) {
  for (FrozenMesh& mesh : problem.meshes) {
    SimplexMesh settled{positions_of(mesh.end), mesh.start.neighbours};
    mesh.end_normals = normals_of(settled);
  }
  problem.start_mm = rms(problem.meshes, [&](std::size_t k) { return pose_of(problem.meshes[k].start.positions); });
}

EngineMesh engine_mesh_of(const MeshItem& item, bool finest) {
  EngineMesh m;
  m.positions = item.mesh.positions, m.previous = item.previous, m.neighbours = item.mesh.neighbours;
  m.shape = item.shape, m.profiles = item.profiles, m.region = &item.region, m.parameters = item.parameters;
  m.finest = finest;
  return m;
}

/// Stores in `problem` the targets that a new engine finds for the current pose of the session.
void find_targets(const Session& session, const EngineFactory& make_engine, FrozenProblem& problem) {
  const Scene& scene = session.scene();
  const Volume& volume = session.volume();
  if (volume.empty()) return;
  const std::unique_ptr<Engine> engine = make_engine();
  engine->set_volume(volume);
  std::vector<EngineMesh> meshes;
  for (const MeshItem& item : scene.meshes)
    meshes.push_back(engine_mesh_of(item, is_finest(item, scene.simulation, volume.geometry().spacing_mm.minCoeff())));
  engine->load(meshes, scene.simulation);
  engine->step(1);
  for (std::size_t k = 0; k < scene.meshes.size(); ++k) {
    const MeshItem& item = scene.meshes[k];
    const MeshNeeds needs{item.parameters, {item.mesh.vertex_count(), !item.shape.empty(), item.profiles.size()}};
    for (const ForceInfo& force : force_list()) {
      if (force.targets == nullptr || !needs.acts(force.id)) continue;
      std::vector<Vec4>& targets = problem.meshes[k].targets[static_cast<std::size_t>(force.id)];
      targets.resize(item.mesh.positions.size());
      engine->read_targets(static_cast<int>(k), force.id, targets);
    }
  }
}

ReferenceModel model_of(const FrozenMesh& mesh, const Volume& volume) {
  ReferenceScene scene;
  scene.neighbours = mesh.start.neighbours, scene.forces = mesh.forces, scene.shape = mesh.shape;
  for (std::size_t force = 0; force < mesh.targets.size(); ++force) scene.targets[force] = mesh.targets[force];
  scene.points_mm = mesh.points_mm;
  scene.voxel_mm = volume.empty() ? 1.0 : volume.geometry().spacing_mm.minCoeff();
  return {scene, pose_of(mesh.start.positions)};
}

}  // namespace

ForceParameters FrozenMesh::active_forces() const {
  ForceParameters active = forces;
  for (const ForceInfo& force : force_list())
    if (force.targets != nullptr && targets[static_cast<std::size_t>(force.id)].empty())
      active.values[static_cast<int>(force.id)][0] = 0;
  return active;
}

int FrozenProblem::vertex_count() const {
  int count = 0;
  for (const FrozenMesh& mesh : meshes) count += mesh.start.vertex_count();
  return count;
}

void FrozenProblem::load(Engine& engine, const SimulationParameters& settings) const {
  std::vector<EngineMesh> list;
  for (const FrozenMesh& mesh : meshes) {
    EngineMesh m;
    m.positions = mesh.start.positions, m.previous = mesh.start.positions, m.neighbours = mesh.start.neighbours;
    m.shape = mesh.shape;
    m.parameters = mesh.active_forces();
    list.push_back(m);
  }
  engine.set_volume(volume);
  SimulationParameters frozen = settings;
  frozen.refresh_interval = 1e6f;  // points remain bound to the same vertices
  // The bounds and the timesteps of the methods are those of unit masses.
  frozen.area_in_mass = 0, frozen.area_in_force = 0;
  engine.load(list, frozen);
  for (std::size_t k = 0; k < meshes.size(); ++k)
    for (int force = 0; force < kForceCount; ++force)
      if (const std::vector<Vec4>& targets = meshes[k].targets[static_cast<std::size_t>(force)]; !targets.empty())
        engine.set_fixed_targets(static_cast<int>(k), static_cast<ForceId>(force), targets);
  std::vector<EnginePoint> points;
  for (std::size_t k = 0; k < meshes.size(); ++k)
    for (const Eigen::Vector3d& p : meshes[k].points_mm) points.push_back({static_cast<int>(k), p});
  engine.set_points(points);
}

PoseError FrozenProblem::error_mm(Engine& engine) const {
  return rms(meshes, [&](std::size_t k) {
    std::vector<Eigen::Vector3f> positions(meshes[k].start.positions.size()), previous(positions.size());
    engine.read(static_cast<int>(k), positions, previous);
    return pose_of(positions);
  });
}

float FrozenProblem::stable_timestep(float damping) const {
  float smallest = std::numeric_limits<float>::infinity();
  for (const FrozenMesh& mesh : meshes) {
    ForceParameters active = mesh.active_forces();
    for (int force = 0; force < kForceCount; ++force)
      if (mesh.points_mm.empty() && (kPullingForces >> force & 1u) != 0) active.values[force][0] = 0;
    smallest = std::min(smallest, simplexseg::stable_timestep(stiffness_bound(active, mesh.shape), damping));
  }
  return smallest;
}

FrozenProblem frozen_problem_of(const Scene& scene, const Volume& volume, bool from_start,
                                const EngineFactory& make_engine, const Poll& poll) {
  if (scene.meshes.empty()) throw Error("study", "the scene has no mesh", "add one to 'meshes'");
  Session session(make_engine());
  session.open(scene, volume);
  std::vector<MeshItem> starts = session.scene().meshes;
  int max_steps = scene.steps > 0 ? scene.steps : kMaxStepsToTargets;
  if (from_start) max_steps = 0;
  for (int done = 0; done < max_steps;) {
    poll();
    const Advance part = session.advance_steps(std::min(kStepsBetweenPolls, max_steps - done), true);
    if (part.failure) throw Error(*part.failure);
    done += part.steps;
    if (part.refined)
      for (std::size_t k = 0; k < starts.size(); ++k)
        if (session.scene().meshes[k].mesh.vertex_count() != starts[k].mesh.vertex_count())
          starts[k] = session.scene().meshes[k];
    if (part.at_rest || part.steps == 0) break;
  }
  FrozenProblem problem;
  problem.volume = volume;
  problem.simulation = scene.simulation;
  for (const MeshItem& item : starts) {
    FrozenMesh& mesh = problem.meshes.emplace_back();
    mesh.start = item.mesh, mesh.shape = item.shape, mesh.forces = item.parameters;
  }
  for (const EnginePoint& point : engine_points(session.scene()))
    problem.meshes[static_cast<std::size_t>(point.mesh)].points_mm.push_back(point.position_mm);
  find_targets(session, make_engine, problem);
  problem.converged = true;
  double residual = 0;
  int systems = 0;
  for (std::size_t k = 0; k < problem.meshes.size(); ++k) {
    poll();
    FrozenMesh& mesh = problem.meshes[k];
    const ReferenceModel model = model_of(mesh, volume);
    FixedPoint found = find_fixed_point(model, pose_of(mesh.start.positions), kToleranceMm);
    systems += found.iterations;
    // Second attempt from the final pose of the run, which is near the fixed point.
    if (!found.converged && !from_start)
      found = find_fixed_point(model, pose_of(session.scene().meshes[k].mesh.positions), kToleranceMm);
    mesh.end = found.pose;
    problem.converged = problem.converged && found.converged;
    residual = std::max(residual, found.residual_mm);
    systems += found.iterations;
  }
  problem.how = std::string(problem.converged ? "found" : "NOT FOUND to 1e-9 mm") + " in double after " +
                std::to_string(systems) + " linear systems; largest residual of a vertex " +
                scientific_text(residual, 1) + " mm";
  set_normals_and_start_error(problem);
  return problem;
}

FrozenProblem make_membrane(bool half, int vertices) {
  constexpr double kRadiusMm = 30, kSprings = 5, kPull = 2;
  constexpr int kEvery = 8;
  FrozenMesh mesh;
  mesh.start = make_sphere({0, 0, 0}, kRadiusMm, sphere_level_for(vertices));
  mesh.forces = forces_with({{"smoothing", "weight", kSprings},
                             {"smoothing", "evenness", 0},
                             {"smoothing", "curvature", 0},
                             {"attraction", "weight", kPull},
                             {"attraction", "order", 0}});
  const int n = mesh.start.vertex_count();
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(n, 3);
  // Subdivision numbers adjacent vertices consecutively, so the selected vertices are spread over the whole sphere.
  for (int i = 0; i < n; ++i) {
    double diagonal = kSprings;
    for (const int j : mesh.start.neighbours[static_cast<std::size_t>(i)]) entries.emplace_back(i, j, -kSprings / 3);
    const Eigen::Vector3d x = mesh.start.positions[static_cast<std::size_t>(i)].cast<double>(), u = x / kRadiusMm;
    if (i % kEvery == 0 && (!half || x.z() >= 0)) {
      // The point lies on the line through the centre and the vertex, so this vertex is and remains the nearest.
      const Eigen::Vector3d point = x * (1 + 0.08 * (3 * u.z() * u.z() - 1) / 2 + 0.05 * u.x() * u.y());
      mesh.points_mm.push_back(point);
      diagonal += kPull;
      right.row(i) = kPull * point;
    }
    entries.emplace_back(i, i, diagonal);
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky(matrix);
  const Eigen::MatrixX3d solution = cholesky.solve(right);
  mesh.end = solution.transpose();
  FrozenProblem problem;
  problem.simulation = default_simulation_parameters();
  problem.converged = cholesky.info() == Eigen::Success && mesh.end.allFinite();
  problem.how = "solved by a sparse Cholesky factorisation in double";
  problem.meshes.push_back(std::move(mesh));
  set_normals_and_start_error(problem);
  return problem;
}

}  // namespace simplexseg
