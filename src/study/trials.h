// SPDX-License-Identifier: Apache-2.0
// Building blocks of trials: scenes made from phantoms and functions, without files.
#pragma once
#include <initializer_list>

#include "step/simulation_parameters.h"
#include "study/phantom.h"
#include "study/stability_case.h"

namespace simplexseg {

inline constexpr double kBallRadius = 19.2;  ///< radius of the sphere in ball_volume(), mm; centred at the origin

struct Value {
  const char* force;
  const char* parameter;
  float value;
};
/// Default parameters with all weights 0, then changed to these values. Throws Error for an unknown name.
ForceParameters forces_with(std::initializer_list<Value> values);
void set_value(ForceParameters& forces, const Value& value);
/// Smoothing 0.5, region 0.5, attraction 2, independent of the defaults.
ForceParameters usual_forces();
/// Timestep 1, damping 0.9, timestep limit on, refresh every third step, no refinement.
SimulationParameters usual_settings();

/// 32^3 voxels of 2 mm around the origin with a bright sphere of kBallRadius; float32. Created once.
const Volume& ball_volume();
const Phantom& phantom_of(const std::string& kind);
/// Volume with the same voxels, its grid scaled about the origin and then shifted.
Volume scaled_and_shifted(const Volume& volume, double scale, const Eigen::Vector3d& shift_mm);
/// Volume whose voxel at each position (mm) is value(position).
Volume volume_of(VoxelType type, std::array<int, 3> size, const Eigen::Vector3d& spacing_mm,
                 const std::function<double(const Eigen::Vector3d&)>& value);

SimplexMesh transformed(SimplexMesh mesh, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map);
/// Adds uniform noise of up to `share` of the mean edge to every coordinate; the noise is the same on every machine.
SimplexMesh add_noise(SimplexMesh mesh, double share);

/// Trial with one mesh "ball" of this pose in this volume, without an error measure.
Trial trial_of(SimplexMesh mesh, const Volume& volume, const ForceParameters& forces);
/// Trial with a sphere of 15 mm, 320 vertices, in ball_volume(); it should end on the ball's surface.
Trial ball_trial();
void add_point(Trial& trial, const Eigen::Vector3d& position_mm);

/// Largest | |p - centre| - radius | of the first mesh.
std::function<double(const Scene&)> radial_error(double radius_mm, const Eigen::Vector3d& centre_mm = {0, 0, 0});
/// Distance of the nearest vertex to a position.
std::function<double(const Scene&)> distance_to(const Eigen::Vector3d& position_mm);
/// Largest distance of a vertex from its position in this pose.
std::function<double(const Scene&)> distance_from(const SimplexMesh& start);
/// |volume / start - 1|.
std::function<double(const Scene&)> volume_error(const SimplexMesh& start);
/// 1 - Dice with the nonzero labels of a phantom.
std::function<double(const Scene&)> dice_error(const Volume& labels);

}  // namespace simplexseg
