// SPDX-License-Identifier: Apache-2.0
// Scene with fixed image targets: every method has the same, known fixed point.
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

/// Callback for long operations, called regularly; may throw to cancel the operation.
using Poll = std::function<void()>;

struct FrozenMesh {
  SimplexMesh start;  ///< initial pose for every method
  std::vector<Vec4> shape;
  ForceParameters forces{};
  std::array<std::vector<Vec4>, kForceCount> targets;  ///< targets of each image force; empty: the force does not act
  std::vector<Eigen::Vector3d> points_mm;
  Pose end;          ///< fixed point
  Pose end_normals;  ///< unit normals at the fixed point

  /// Parameters of the forces, with weight 0 for image forces without targets.
  ForceParameters active_forces() const;
};

/// Root mean square errors over all vertices, mm.
struct PoseError {
  double whole, normal;  ///< distance to the fixed point; its component along the normals at the fixed point
};

struct FrozenProblem {
  std::vector<FrozenMesh> meshes;
  Volume volume;                      ///< its smallest spacing is the unit "voxel" of parameters; may be empty
  SimulationParameters simulation{};  ///< settings of the scene
  std::string how;                    ///< method and accuracy of the fixed point, for reports
  bool converged = false;             ///< whether the fixed point has the required accuracy
  PoseError start_mm{};

  int vertex_count() const;
  /// Loads initial poses, targets and points into the engine, with the settings of a method.
  void load(Engine& engine, const SimulationParameters& settings) const;
  /// Errors of the current poses in the engine.
  PoseError error_mm(Engine& engine) const;
  /// Largest timestep with which Verlet with this damping is stable for all meshes.
  float stable_timestep(float damping) const;
};

/// Runs the scene with its own settings until it settles, for its number of steps (2000 if it has none); meshes without
/// a pose start as spheres. The image targets at the final pose become fixed; the start is the pose with which each
/// mesh began its last refinement level. With `from_start`, no step is run, and the targets are those at the start. The
/// fixed point is computed in double, to 1e-9 mm. Throws Error for a scene without meshes or if the run fails.
FrozenProblem frozen_problem_of(const Scene& scene, const Volume& volume, bool from_start,
                                const EngineFactory& make_engine, const Poll& poll);

/// Linear problem with a known solution: springs between neighbours (smoothing without evenness or preserved curvature,
/// weight 5) on a sphere of at least `vertices` vertices, and attraction of every eighth vertex to a point (weight 2);
/// with `half`, only of vertices with z >= 0. The fixed point is computed by a sparse Cholesky factorisation.
FrozenProblem make_membrane(bool half, int vertices);

}  // namespace simplexseg
