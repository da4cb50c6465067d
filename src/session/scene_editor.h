// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "session/command.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;
struct PromptStroke;

/// Part of the engine that must be updated after a change of the scene. Meshes includes parameters and points.
enum class EngineUpdate { Nothing, Points, Parameters, Meshes };

/// Effect of a command on a scene.
struct SceneChange {
  EngineUpdate update = EngineUpdate::Nothing;
  ItemId added = 0;  ///< id of the new mesh, point, measurement or layer; 0: none
};

/// Executes commands on a scene. There is one overload for each command except those that the session executes itself
/// (undo, redo, field updates and comparisons); a missing overload does not compile. The caller updates the engine.
/// Each overload throws Error if the command cannot be executed; a command for several meshes may then have changed
/// some of them.
class SceneEditor {
 public:
  /// `next_id`: id of the next new item; incremented for each. The references must outlive this object.
  SceneEditor(Scene& scene, const Volume& volume, ItemId& next_id)
      : scene_(scene), volume_(volume), next_id_(next_id) {}

  SceneChange execute(const AddMesh& command);
  SceneChange execute(const DeleteMesh& command);
  SceneChange execute(const EditMesh& command);
  SceneChange execute(const SetForceParameter& command);
  SceneChange execute(const SetSimulationParameter& command);
  SceneChange execute(const AddPoint& command);
  SceneChange execute(const MovePoint& command);
  SceneChange execute(const DeletePoint& command);
  SceneChange execute(const ResetPose& command);
  SceneChange execute(const RecordProfiles& command);
  SceneChange execute(const RefineMesh& command);
  SceneChange execute(const DuplicateMesh& command);
  SceneChange execute(const ReorderMesh& command);
  SceneChange execute(const SetParameters& command);
  SceneChange execute(const SetReference& command);
  SceneChange execute(const ResizePoint& command);
  SceneChange execute(const EditVoxels& command);
  SceneChange execute(const AddLasso& command);
  SceneChange execute(const SetIntensityRange& command);
  SceneChange execute(const SetModel& command);
  SceneChange execute(const SetImages& command);
  SceneChange execute(const SetStartModes& command);
  SceneChange execute(const SetStart& command);
  SceneChange execute(const ChooseLabelPreset& command);
  SceneChange execute(const AddMeasurement& command);
  SceneChange execute(const MoveMeasurement& command);
  SceneChange execute(const RenameMeasurement& command);
  SceneChange execute(const DeleteMeasurement& command);
  SceneChange execute(const AddLayer& command);
  SceneChange execute(const EditLayer& command);
  SceneChange execute(const RemoveLayer& command);
  SceneChange execute(const FilterVolume& command);

 private:
  MeshItem& item_of(ItemId mesh);  ///< mesh with this id; throws Error for 0 or an unknown mesh
  /// Meshes whose pose may change: the given mesh, or for 0 all meshes that are not locked. Throws Error for a locked
  /// or unknown mesh.
  std::vector<MeshItem*> movable_items_of(ItemId mesh);
  std::vector<MeshItem*> items_of(ItemId mesh);  ///< given mesh, 0: all meshes; throws Error for an unknown mesh
  /// Records the label of a mesh for its name (LabelNumbers), unless the name is one of "mesh 1", "mesh 2" ...
  void remember_label(const MeshItem& item);
  /// Adds the strokes of a box to a mesh; they are applied in the same update as its seed.
  void add_strokes(const std::vector<PromptStroke>& strokes, ItemId mesh);
  /// Lasso of a mesh with its strokes, without an id. `starts`: the mesh starts from it. Throws Error for one that the
  /// volume cannot have.
  UserPoint new_lasso(MarkKind kind, const std::vector<Eigen::Vector3d>& contour_mm, const Eigen::Vector3d& normal,
                      ItemId mesh, bool starts);
  /// Point with this id, to be changed or deleted; throws Error for an unknown point or one of a locked mesh.
  UserPoint& editable_point_of(ItemId point);
  /// Measurement with this id; throws Error for an unknown one.
  Measurement& measurement_of(ItemId measurement);
  /// Layer with this id; throws Error for an unknown one.
  LayerItem& layer_of(ItemId layer);

  Scene& scene_;
  const Volume& volume_;
  ItemId& next_id_;
};

}  // namespace simplexseg
