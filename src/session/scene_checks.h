// SPDX-License-Identifier: Apache-2.0
// Checks of scenes and of the values of commands. Each throws Error with a message of one line.
#pragma once
#include <Eigen/Core>
#include <string>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Throws unless the value lies in the parameter's range; NaN does not. `owner`: owner of the parameter, for the
/// message.
void check_value(const ParameterInfo& info, float value, const std::string& owner);
/// Throws unless the sphere is finite, its radius is above 0 and its centre lies in the volume (if there is one).
/// `name`: name of the mesh.
void check_seed(const Seed& seed, const std::string& name, const Volume& volume);
/// Throws unless the position of a point is finite and within 1e9 mm.
void check_position(const Eigen::Vector3d& position_mm);
/// Throws unless the radius of the ball that a point marks is above 0 and at most 1000 mm.
void check_radius(double radius_mm);
/// Throws unless a point of this kind may lie there: inside and outside points must lie in the volume.
void check_mark(MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume);
/// Checks a scene before it is opened on the volume: values, seeds, poses, points, ids. Assigns ids to meshes and
/// points that have none. Returns the next unused id.
ItemId check_scene(Scene& scene, const Volume& volume);

}  // namespace simplexseg
