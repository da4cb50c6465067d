// SPDX-License-Identifier: Apache-2.0
// What trials are made of: scenes from phantoms and functions, no files.
#pragma once
#include <initializer_list>

#include "step/simulation_parameters.h"
#include "study/phantom.h"
#include "study/stability_case.h"

namespace simplexseg {

inline constexpr double kBallRadius = 19.2;  ///< of the sphere in ball_volume(), mm; its centre is the origin

struct Value {
  const char* force;
  const char* parameter;
  float value;
};
/// Defaults with all weights 0, then these. Throws Error for a name that is none.
ForceParameters forces_with(std::initializer_list<Value> values);
void set_value(ForceParameters& forces, const Value& value);
/// Smoothing 0.5, region 0.5, attraction 2, whatever the defaults are.
ForceParameters usual_forces();
/// Timestep 1, damping 0.9, limit on, refreshed every third step, no refinement.
SimulationParameters usual_settings();

/// 32^3 voxels of 2 mm around the origin with a bright sphere of kBallRadius; float32. Made once.
const Volume& ball_volume();
const Phantom& phantom_of(const std::string& kind);
/// The voxels as they are, their grid scaled about the origin, then moved.
Volume placed(const Volume& volume, double scale, const Eigen::Vector3d& shift_mm);
/// A volume whose voxel at a position (mm) is value(position).
Volume volume_of(VoxelType type, std::array<int, 3> size, const Eigen::Vector3d& spacing_mm,
                 const std::function<double(const Eigen::Vector3d&)>& value);

SimplexMesh transformed(SimplexMesh mesh, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map);
/// Uniform noise of up to `share` of the mean edge on every coordinate; the same on every machine.
SimplexMesh with_noise_of(SimplexMesh mesh, double share);

/// One mesh "ball" with this pose in this volume. Error: none.
Trial trial_of(SimplexMesh mesh, const Volume& volume, const ForceParameters& forces);
/// A sphere of 15 mm, 320 vertices, in ball_volume(), to end on the ball's surface.
Trial ball_trial();
void add_point(Trial& trial, const Eigen::Vector3d& position_mm);

/// Largest | |p - centre| - radius | of the first mesh.
std::function<double(const Scene&)> radial_error(double radius_mm, const Eigen::Vector3d& centre_mm = {0, 0, 0});
/// Distance of the nearest vertex to a position.
std::function<double(const Scene&)> distance_to(const Eigen::Vector3d& position_mm);
/// Largest way of a vertex from this pose.
std::function<double(const Scene&)> distance_from(const SimplexMesh& start);
/// |volume / start - 1|.
std::function<double(const Scene&)> volume_error(const SimplexMesh& start);
/// 1 - Dice with the labels of a phantom that are not 0.
std::function<double(const Scene&)> dice_error(const Volume& labels);

}  // namespace simplexseg
