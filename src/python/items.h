// SPDX-License-Identifier: Apache-2.0
// What a session hands out of its scene: names of meshes and points, which stay valid while the session lives, and are
// refused once the item is gone.
#pragma once
#include <memory>

#include "python/session_owner.h"

namespace simplexseg::python {

/// simplexseg.SceneMesh and simplexseg.ScenePoint.
struct SceneItem {
  std::shared_ptr<SessionOwner> session;
  ItemId id;
  bool operator==(const SceneItem&) const = default;
};
struct SceneMesh : SceneItem {};
struct ScenePoint : SceneItem {};

/// Those of the scene, of one mesh alone where `mesh` is not 0.
std::vector<SceneMesh> meshes_of(const std::shared_ptr<SessionOwner>& session);
std::vector<ScenePoint> points_of(const std::shared_ptr<SessionOwner>& session, ItemId mesh = 0);

/// Carries out a command. Returns the id of what it added, else 0.
ItemId apply(SessionOwner& session, const Command& command);
/// Sets a parameter of a mesh, or of all where `mesh` is 0. Throws Error for an unknown name or a value out of range.
void set_parameter(SessionOwner& session, ItemId mesh, const std::string& name, const pybind11::object& value);

}  // namespace simplexseg::python
