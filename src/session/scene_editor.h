// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "session/command.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// What of the engine has to follow a change of the scene; its meshes bring parameters and points with them.
enum class EngineUpdate { Nothing, Points, Parameters, Meshes };

/// What a command did to a scene.
struct SceneChange {
  EngineUpdate update = EngineUpdate::Nothing;
  ItemId added = 0;  ///< the mesh or point that is new
};

/// What each command does to a scene: one overload for each but those of the session itself (undo, redo, fields), so
/// that one that is forgotten does not compile. It knows no engine: whoever has one brings it up to date. Each throws
/// Error when the command cannot be carried out; the scene may have changed in part then, where the command is for
/// several meshes.
class SceneEditor {
 public:
  /// `next_id`: the id of the next item, counted on.
  SceneEditor(Scene& scene, const Volume& volume, ItemId& next_id)
      : scene_(scene), volume_(volume), next_id_(next_id) {}

  SceneChange carry_out(const AddMesh& command);
  SceneChange carry_out(const DeleteMesh& command);
  SceneChange carry_out(const EditMesh& command);
  SceneChange carry_out(const SetForceParameter& command);
  SceneChange carry_out(const SetSimulationParameter& command);
  SceneChange carry_out(const AddPoint& command);
  SceneChange carry_out(const MovePoint& command);
  SceneChange carry_out(const DeletePoint& command);
  SceneChange carry_out(const ResetPose& command);
  SceneChange carry_out(const RecordProfiles& command);
  SceneChange carry_out(const RefineMesh& command);
  SceneChange carry_out(const DuplicateMesh& command);
  SceneChange carry_out(const PlaceMesh& command);
  SceneChange carry_out(const SetParameters& command);
  SceneChange carry_out(const SetReference& command);
  SceneChange carry_out(const ResizePoint& command);

 private:
  MeshItem& item_of(ItemId mesh);  ///< throws Error when there is none
  /// The same for what changes its pose: throws Error for a locked one; 0: all that are not locked.
  std::vector<MeshItem*> movable_items_of(ItemId mesh);
  std::vector<MeshItem*> items_of(ItemId mesh);  ///< 0: all; throws Error when there is no such mesh
  UserPoint& point_of(ItemId point);             ///< throws Error when there is none

  Scene& scene_;
  const Volume& volume_;
  ItemId& next_id_;
};

}  // namespace simplexseg
