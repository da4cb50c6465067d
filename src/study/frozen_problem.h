// SPDX-License-Identifier: Apache-2.0
// A scene whose image targets do not change: every method then has the same fixed point, which is known.
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "image/volume.h"
#include "session/scene.h"
#include "step/engine.h"
#include "step/simulation_parameters.h"
#include "study/reference_model.h"
#include "study/stability_case.h"

namespace simplexseg {

/// Called now and then during long work; may throw to end it.
using Poll = std::function<void()>;

struct FrozenMesh {
  SimplexMesh start;  ///< the pose that every method starts from
  std::vector<Vec4> shape;
  ForceParameters forces{};
  std::array<std::vector<Vec4>, kForceCount> targets;  ///< of each image force; empty: it does not act
  std::vector<Eigen::Vector3d> points_mm;
  Pose end;          ///< the fixed point
  Pose end_normals;  ///< unit normals there

  /// Without those that have no targets: they do not act in the fixed point either.
  ForceParameters acting_forces() const;
};

/// Root mean squares over all vertices, mm.
struct PoseError {
  double whole, normal;  ///< the distance, and its part along the end's normals
};

struct FrozenProblem {
  std::vector<FrozenMesh> meshes;
  Volume volume;                      ///< for the unit "voxel" of parameters; may be empty
  SimulationParameters simulation{};  ///< the scene's
  std::string how;                    ///< how the fixed point was found, and how well, in a sentence
  bool converged = false;             ///< to what was asked for
  PoseError start_mm{};

  int vertex_count() const;
  /// Loads the start's poses, targets and points. `settings`: those of the method.
  void load(Engine& engine, const SimulationParameters& settings) const;
  /// Distance of the engine's poses from the fixed point.
  PoseError error_mm(Engine& engine) const;
  /// Largest stable timestep of Verlet with this damping, of all meshes.
  float stable_timestep(float damping) const;
};

/// Runs the scene (meshes without a pose start as their spheres) with its own settings until rest, or its steps, or
/// 2000; freezes the targets of the image forces found last; the start is the pose with which each mesh began its last
/// level. With `from_start` there is no run, and the targets are those that the start finds. The fixed point is found
/// in double, to 1e-9 mm. Throws Error for a scene without meshes or that fails while it runs.
FrozenProblem frozen_problem_of(const Scene& scene, const Volume& volume, bool from_start,
                                const EngineFactory& make_engine, const Poll& poll);

/// A linear problem whose solution is known: springs between neighbours (smoothing without evenness or kept curvature,
/// weight 5) on a sphere's dual with `vertices` or more, and every eighth vertex pulled to a point (weight 2); `half`:
/// of those with z >= 0 alone. The fixed point comes of a sparse Cholesky factorisation.
FrozenProblem make_membrane(bool half, int vertices);

}  // namespace simplexseg
