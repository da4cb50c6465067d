// SPDX-License-Identifier: Apache-2.0
// What a scene and the values of a command must be before the simulation takes them. Each check throws Error, one line
// that names what is wrong.
#pragma once
#include <Eigen/Core>
#include <string>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Throws unless the value lies in the parameter's range, which a NaN does not. `owner`: what has the parameter.
void check_value(const ParameterInfo& info, float value, const std::string& owner);
/// Throws unless the sphere is finite, has a radius above 0 and its centre lies in the volume (anywhere, when that is
/// empty). `name`: of the mesh.
void check_seed(const Seed& seed, const std::string& name, const Volume& volume);
/// Throws unless the position of a point is finite and within 1e9 mm.
void check_position(const Eigen::Vector3d& position_mm);
/// Throws unless the radius of the ball that a point marks is above 0 and at most 1000 mm.
void check_radius(double radius_mm);
/// Throws unless a point of this kind can lie there: a mark of what is inside or outside lies in the volume.
void check_mark(MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume);
/// Checks all of a scene that is to be opened on the volume: values, seeds, meshes that have a pose, points, ids. Gives
/// ids to meshes and points that have none. Returns the next id that is free.
ItemId check_scene(Scene& scene, const Volume& volume);

}  // namespace simplexseg
