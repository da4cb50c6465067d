// SPDX-License-Identifier: Apache-2.0
// Building blocks of trials: scenes made from phantoms and functions, without files.
#pragma once
#include <initializer_list>

#include "step/simulation_parameters.h"
#include "study/phantom.h"
#include "study/stability_case.h"

namespace simplexseg {

inline constexpr double kBallRadius = 19.2;  ///< radius of the sphere in ball_volume(), mm; its centre is the origin

struct Value {
  const char* force;
  const char* parameter;
  float value;
};
/// Default parameters with all weights 0, evidence from intensities and smoothing curvature 0.5, then changed to these
/// values. Throws Error for an unknown name.
ForceParameters forces_with(std::initializer_list<Value> values);
void set_value(ForceParameters& forces, const Value& value);
/// Parameters of forces_with() with the weights smoothing 0.5, evidence 0.5 and attraction 2.
ForceParameters usual_forces();
/// Default settings with timestep 1, damping 0.9, timestep limit on, refresh in every third step and no refinement.
SimulationParameters usual_settings();

/// Volume of 32^3 voxels of 2 mm, centred at the origin, with a bright sphere of radius kBallRadius; float32. Created
/// once.
const Volume& ball_volume();
const Phantom& phantom_of(const std::string& kind);
/// Volume with the same voxels, whose grid is scaled about the origin and then shifted.
Volume scaled_and_shifted(const Volume& volume, double scale, const Eigen::Vector3d& shift_mm);
/// Volume of the given voxel type, number of voxels and spacing, centred at the origin. The value of each voxel is
/// value(its position in mm).
Volume volume_of(VoxelType type, std::array<int, 3> size, const Eigen::Vector3d& spacing_mm,
                 const std::function<double(const Eigen::Vector3d&)>& value);

SimplexMesh transformed(SimplexMesh mesh, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map);
/// Adds uniform noise of magnitude up to `share` of the mean edge to every coordinate; the noise is the same on every
/// machine.
SimplexMesh add_noise(SimplexMesh mesh, double share);

/// Trial with one mesh "ball" of this pose in this volume, without an error function.
Trial trial_of(SimplexMesh mesh, const Volume& volume, const ForceParameters& forces);
/// Trial with a sphere of radius 15 mm and 320 vertices in ball_volume(); the mesh should end on the surface of the
/// ball.
Trial ball_trial();
void add_point(Trial& trial, const Eigen::Vector3d& position_mm);

/// Largest | |p - centre| - radius | over the vertices p of the first mesh, mm.
std::function<double(const Scene&)> radial_error(double radius_mm, const Eigen::Vector3d& centre_mm = {0, 0, 0});
/// Distance of the nearest vertex of the first mesh from a position, mm.
std::function<double(const Scene&)> distance_to(const Eigen::Vector3d& position_mm);
/// Largest distance of a vertex of the first mesh from its position in `start`, mm.
std::function<double(const Scene&)> distance_from(const SimplexMesh& start);
/// Relative error of the volume of the first mesh: |volume / volume of `start` - 1|.
std::function<double(const Scene&)> volume_error(const SimplexMesh& start);
/// Error 1 - Dice of the first mesh with the nonzero labels of a phantom.
std::function<double(const Scene&)> dice_error(const Volume& labels);

}  // namespace simplexseg
