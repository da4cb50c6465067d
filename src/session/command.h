// SPDX-License-Identifier: Apache-2.0
// Commands: actions of the user, updates of fields, and comparisons of meshes with their fields. Each is one line of
// the log. Each command that changes the scene is one unit of undo, or belongs to the previous unit if `continues` is
// set.
#pragma once
#include <map>
#include <string>
#include <variant>

#include "session/scene.h"

namespace simplexseg {

/// Adds a mesh: the sphere `seed`, or the mesh of `start` if given. Its parameters are those of the mesh `like`, or the
/// scene's parameters of a new mesh if `like` is 0.
struct AddMesh {
  std::string name;  ///< empty: the first unused name of "mesh 1", "mesh 2" ...
  Seed seed;
  std::optional<Colour> colour;  ///< none: the first unused colour of the palette
  ItemId like = 0;
  std::optional<MeshStart> start{};  ///< must contain a mesh; `seed` then lies inside that mesh
  /// Corners of a box (field/box_prompt.h) instead of a seed: the mesh gets the seed and the strokes of
  /// prompt_of_box(). Four, or none.
  std::vector<Eigen::Vector3d> box_mm{};
  SegmentCode code{};  ///< MeshItem::code
  /// Closed contour around the object in a slice (field/lasso_prompt.h) instead of a seed: the mesh gets the seed of
  /// seed_of_lasso() and an inside lasso. At least three vertices, or none.
  std::vector<Eigen::Vector3d> contour_mm{};
  Eigen::Vector3d contour_normal{0, 0, 1};   ///< unit normal of its slice
  std::shared_ptr<const MeshModel> model{};  ///< MeshItem::model
};
struct DeleteMesh {
  ItemId mesh;
};
/// Changes the attributes of a mesh for which a value is given. A new name without a label gives the mesh the label of
/// that name (LabelNumbers), unless another mesh has it.
struct EditMesh {
  ItemId mesh;
  std::optional<std::string> name;
  std::optional<Colour> colour;
  std::optional<bool> visible;
  std::optional<int> label;
  std::optional<bool> locked{};
  std::optional<float> opacity{};
  std::optional<SegmentCode> code{};  ///< empty: the code follows from the name
};
/// Sets the reference with which reports compare the mesh. The pose of the mesh does not change.
struct SetReference {
  ItemId mesh;
  std::optional<Reference> reference;  ///< none: removes the reference
  bool continues = false;              ///< whether the command is undone together with the SetReference before it
};
/// Sets one parameter of a force. mesh = 0: for every mesh.
struct SetForceParameter {
  ItemId mesh;
  ForceId force;
  int parameter;  ///< index in the force's table
  float value;
  bool continues = false;  ///< whether it belongs to the slider movement of the previous command: undone together
};
struct SetSimulationParameter {
  int parameter;  ///< index in simulation_table()
  float value;
  bool continues = false;  ///< see SetForceParameter
};
/// Sets all force parameters of a mesh (mesh = 0: of every mesh) and, if given, the parameters of the simulation.
struct SetParameters {
  ItemId mesh;
  ForceParameters forces;
  std::optional<SimulationParameters> simulation;
};
struct AddPoint {
  ItemId mesh;
  Eigen::Vector3d position_mm;
  MarkKind kind = MarkKind::Boundary;
  double radius_mm = 0;                    ///< radius of the marked ball, mm; 0: mark_radius_mm()
  Eigen::Vector3d outward{0, 0, 0};        ///< boundary point: direction out of the object; 0: outward_at()
  std::vector<Eigen::Vector3d> path_mm{};  ///< stroke: UserPoint::path_mm
  PaintBrush brush{};                      ///< paint or eraser: UserPoint::brush; a ball or a disc needs a radius
  /// Paint: SmartPaint, Freeze, or None for all voxels under the brush.
  VoxelEdit edit = VoxelEdit::None;
  bool local = false;  ///< a mark: UserPoint::local
};
/// Adds a lasso (field/lasso_prompt.h), which is applied in one update.
struct AddLasso {
  ItemId mesh;
  MarkKind kind = MarkKind::Inside;         ///< Inside or Outside
  std::vector<Eigen::Vector3d> contour_mm;  ///< closed contour, at least three vertices
  Eigen::Vector3d normal{0, 0, 1};          ///< unit normal of its slice
  bool local = false;                       ///< UserPoint::local of its strokes
};
/// Changes the voxels of the object of a mesh; the result is paint (session/edited_voxels.h).
struct EditVoxels {
  ItemId mesh;
  VoxelEdit edit;
  double size = 0;   ///< VoxelEditInfo::size
  ItemId other = 0;  ///< the other mesh, if the edit uses one
};
/// Sets the intensities that the object of a mesh can have (MeshItem::intensity_range).
struct SetIntensityRange {
  ItemId mesh;
  IntensityRange range;    ///< not empty; infinite limits: none
  bool continues = false;  ///< whether it belongs to the drag of the previous command: undone together
};
/// Sets the model of the organ of a mesh (MeshItem::model). Refused for a mesh with MeshItem::start, whose field does
/// not use it.
struct SetModel {
  ItemId mesh;
  std::shared_ptr<const MeshModel> model;  ///< null: none
};
/// Sets the images in which the field of a mesh is solved (MeshItem::images). Refused for a mesh with
/// MeshItem::is_given(), whose field does not use them.
struct SetImages {
  ItemId mesh;
  MeshImages images;
};
/// Starts a mesh from the shape of its model at its seed, deformed by the first modes (MeshItem::start_modes), or from
/// the sphere of its seed again for no modes.
struct SetStartModes {
  ItemId mesh;
  std::vector<float> modes;  ///< deviations, of at most kMostModeDeviations
  bool continues = false;    ///< whether it belongs to the slider movement of the previous command: undone together
};
/// Starts a mesh from the mask of a network, which also becomes the prior of its field, or from its seed again. Refused
/// for a mesh with a model, whose prior the mask would replace.
struct SetStart {
  ItemId mesh;
  std::optional<MeshStart> start;  ///< must contain a mask of a network with its mesh; none: the seed
};
struct MovePoint {
  ItemId point;
  Eigen::Vector3d position_mm;
  bool continues = false;  ///< whether it belongs to the drag of the previous command: undone together
};
/// Changes the radius of the ball that an inside or outside point marks.
struct ResizePoint {
  ItemId point;
  double radius_mm;
  bool continues = false;  ///< whether it belongs to the scroll gesture of the previous command: undone together
};
struct DeletePoint {
  ItemId point;
};
/// Resets a mesh to the sphere of its seed at the first level, or to the labels or mesh from which it starts. mesh = 0:
/// every mesh that is not locked.
struct ResetPose {
  ItemId mesh;
};
/// Records the intensity profiles at the current pose as the reference of the intensity-profile force. mesh = 0: every
/// mesh.
struct RecordProfiles {
  ItemId mesh;
  /// Records the mean profiles of the model instead (MeshItem::model_profiles). Refused for a mesh that does not have
  /// the vertices of its model, refined or not.
  bool from_model = false;
};
/// Refines a mesh, which then has four times as many vertices. mesh = 0: every mesh that is not locked.
struct RefineMesh {
  ItemId mesh;
};
/// Copies a mesh with its pose and points. The copy gets the first unused name of "NAME copy", "NAME copy 2" ..., the
/// first unused label and an unused colour.
struct DuplicateMesh {
  ItemId mesh;
};
/// Moves a mesh to another position in the list.
struct ReorderMesh {
  ItemId mesh;
  int place;  ///< new index in the list, from 0
};
/// Starts to solve the field of a mesh from its current marks in the background. Cannot be undone.
struct StartFieldUpdate {
  ItemId mesh;
};
/// Waits for the field that was started last and attaches it to its mesh, unless the field was cancelled: an undo, a
/// redo or a deletion made it useless. Cannot be undone.
struct CommitFieldUpdate {};
/// Waits for the next preliminary field of the update that was started last, and attaches it to its mesh. Cannot be
/// undone.
struct CommitPreliminaryField {};
/// Stops the field that is being solved and discards its solution; the mesh keeps its field. The automatic update
/// solves it again only when a mark changes, or after RequestFieldUpdate. Cannot be undone. An undo, a redo or a
/// deletion that makes the field useless stops it too; this command then follows in the log and frees its memory.
struct CancelFieldUpdate {};
/// Lets the automatic update solve a field whose update was cancelled. Cannot be undone.
struct RequestFieldUpdate {
  ItemId mesh;
};
/// Starts to compare the present pose of a mesh with its field in the background, and to rebuild the mesh from the
/// field if it no longer approaches it. Undo and redo discard the comparison; so do deletion, lock, reset and
/// refinement of the mesh, and a command after which it no longer uses this field. Cannot be undone.
struct StartFieldComparison {
  ItemId mesh;
};
/// Waits for the comparison of a mesh and replaces the mesh if it was rebuilt; changes nothing if the comparison was
/// discarded. Cannot be undone.
struct CommitFieldComparison {
  ItemId mesh;
};
/// Chooses the labels of names. A mesh with one of these names gets its label; other meshes with a label of these names
/// get an unused one.
struct ChooseLabelPreset {
  std::string preset;  ///< LabelNumbers::preset; "": none
  std::map<std::string, int> by_name;
};
/// Adds a measurement; `points_mm` as in Measurement.
struct AddMeasurement {
  MeasurementKind kind;
  std::vector<Eigen::Vector3d> points_mm;
  std::string name;  ///< empty: the first unused name of "ruler 1", "ruler 2" ...
};
/// Moves points of a measurement, or the whole.
struct MoveMeasurement {
  ItemId measurement;
  std::vector<Eigen::Vector3d> points_mm;  ///< all points, as in Measurement
  bool continues = false;                  ///< whether it belongs to the drag of the previous command: undone together
};
struct RenameMeasurement {
  ItemId measurement;
  std::string name;
};
struct DeleteMeasurement {
  ItemId measurement;
};
/// Adds a layer after the others; the id of `item` is ignored.
struct AddLayer {
  LayerItem item;
};
/// Changes the attributes of a layer for which a value is given.
struct EditLayer {
  ItemId layer;
  std::optional<std::string> name{};
  std::optional<LayerTransform> transform{};
  std::optional<Preprocessing> preprocessing{};
  std::optional<ColourMap> colour_map{};
  std::optional<float> opacity{};
  std::optional<double> window{}, level{};
  std::optional<bool> visible{};
  bool continues = false;  ///< whether it belongs to the drag of the previous command: undone together
};
struct RemoveLayer {
  ItemId layer;
};
/// Sets the filters of the volume. Fields are solved again with the filtered values; the file stays as it is.
struct FilterVolume {
  Preprocessing preprocessing;  ///< check_volume_filters()
};
struct Undo {};
struct Redo {};

using Command = std::variant<AddMesh, DeleteMesh, EditMesh, SetForceParameter, SetSimulationParameter, AddPoint,
                             MovePoint, DeletePoint, ResetPose, RecordProfiles, RefineMesh, DuplicateMesh, ReorderMesh,
                             SetParameters, StartFieldUpdate, CommitFieldUpdate, Undo, Redo, SetReference, ResizePoint,
                             CancelFieldUpdate, RequestFieldUpdate, CommitPreliminaryField, StartFieldComparison,
                             CommitFieldComparison, EditVoxels, ChooseLabelPreset, AddMeasurement, MoveMeasurement,
                             RenameMeasurement, DeleteMeasurement, AddLasso, SetIntensityRange, SetModel, AddLayer,
                             EditLayer, RemoveLayer, FilterVolume, SetImages, SetStartModes, SetStart>;

/// Title of a command in lower case, for example "move point" in the menu item "Undo move point".
const char* title_of(const Command& command);
/// Text of a command in the list of actions, for example "add inside point: kidney" or "Smoothing, weight: all
/// segmentations". `before`: scene before the command.
std::string describe(const Command& command, const Scene& before);

/// Line of the log. `steps`: number of simulation steps between the previous line and the command.
struct LogEntry {
  int steps;
  Command command;
};

}  // namespace simplexseg
