// SPDX-License-Identifier: Apache-2.0
// Handles to meshes, points, measurements and layers of a session. They keep the session alive and raise Error after
// the item is deleted.
#pragma once
#include <memory>

#include "python/session_owner.h"

namespace simplexseg::python {

/// Base of simplexseg.SceneMesh, simplexseg.ScenePoint, simplexseg.SceneMeasurement and simplexseg.SceneLayer.
struct SceneItem {
  std::shared_ptr<SessionOwner> session;
  ItemId id;
  bool operator==(const SceneItem&) const = default;
};
struct SceneMesh : SceneItem {};
struct ScenePoint : SceneItem {};
struct SceneMeasurement : SceneItem {};
struct SceneLayer : SceneItem {};

/// Returns the meshes of the scene.
std::vector<SceneMesh> meshes_of(const std::shared_ptr<SessionOwner>& session);
/// Returns the points of one mesh, or of the scene if `mesh` is 0.
std::vector<ScenePoint> points_of(const std::shared_ptr<SessionOwner>& session, ItemId mesh = 0);
/// Returns the measurements of the scene.
std::vector<SceneMeasurement> measurements_of(const std::shared_ptr<SessionOwner>& session);
/// Adds a measurement. `kind`: "ruler", "angle" or "ellipse". Throws Error for invalid points.
SceneMeasurement add_measurement(const std::shared_ptr<SessionOwner>& session, const std::string& kind,
                                 const std::vector<pybind11::object>& points, const std::string& name);

/// Returns the layers of the scene.
std::vector<SceneLayer> layers_of(const std::shared_ptr<SessionOwner>& session);
/// Adds an image as a layer. `name`: empty: that of the series or the file; `transform`: file, see
/// load_layer_transform(). Throws the errors of the readers.
SceneLayer add_layer(const std::shared_ptr<SessionOwner>& session, const std::filesystem::path& path,
                     const std::string& name, const std::optional<std::filesystem::path>& transform);

/// Applies a command. Returns the id of the added item, or 0.
ItemId apply(SessionOwner& session, const Command& command);
/// Sets a parameter of a mesh, or of all meshes if `mesh` is 0. Throws Error for an unknown name or a value out of
/// range.
void set_parameter(SessionOwner& session, ItemId mesh, const std::string& name, const pybind11::object& value);

}  // namespace simplexseg::python
