// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/colour.h"
#include "core/segment_code.h"
#include "forces/parameters.h"
#include "forces/region_model.h"
#include "image/intensity_range.h"
#include "image/measurement.h"
#include "mesh/simplex_mesh.h"
#include "session/layer.h"
#include "session/mesh_field.h"
#include "session/mesh_images.h"
#include "session/network_mask.h"
#include "session/voxel_edit.h"
#include "step/engine.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

struct OrganModel;
struct PromptStroke;

using ItemId = std::uint32_t;  ///< id of a mesh, point, measurement or layer, unique in a session; 0: none

/// Reference segmentation with which reports compare a mesh.
struct Reference {
  std::string labels;           ///< path of a label volume, as in the scene file
  std::optional<double> value;  ///< label; none: every voxel that is not 0
};

/// Sphere from which a mesh starts.
struct Seed {
  Eigen::Vector3d centre_mm{0, 0, 0};
  double radius_mm = 10;
};

inline constexpr double kMaxErrorMm = 100;  ///< largest MeshStart::error_mm

/// Measures of an object in the study from which it was carried over (session/carry_over.h).
struct EarlierObject {
  double volume_ml = 0;                  ///< 0: not carried over
  double long_mm = 0, short_mm = 0;      ///< axes of object_axes(); 0: unknown
  Eigen::Vector3d centroid_mm{0, 0, 0};  ///< in the frame of that study, LPS
};

/// Start of a mesh other than the sphere of its seed: labels, a mesh of another program, the surface of an earlier
/// study, or the mask of a network. A reset restores the mesh to it.
struct MeshStart {
  std::string path;             ///< path of a label volume or a mesh, as in the scene file; empty for `network`
  std::optional<double> value;  ///< label; none: every voxel that is not 0
  int part = 0;                 ///< connected component, numbered by size from 1, the largest; 0: all
  std::shared_ptr<const SimplexMesh> mesh;
  /// Expected error of the surface (standard deviation), mm. Above 0, the field is solved from the image, and the
  /// surface is its prior (field/surface_prior.h). 0: the inside of the surface is the object, whatever the image.
  double error_mm = 0;
  EarlierObject earlier{};
  /// Mask of a network, of which `mesh` is the surface; `error_mm` is then above 0. Null: none.
  std::shared_ptr<const NetworkMask> network{};
};

/// Largest absolute value of MeshItem::start_modes, deviations.
inline constexpr float kMostModeDeviations = 5;

/// Statistical model of the organ of a mesh: a prior of its field (model/organ_model.h).
struct MeshModel {
  std::string path;      ///< path of the model file, as in the scene file
  std::string checksum;  ///< of the contents of the file
  std::shared_ptr<const OrganModel> organ;
  int number = 0;  ///< index of the organ in the file

  /// Identifies the organ: the checksum, and the number of an organ after the first.
  std::string identity() const { return number == 0 ? checksum : checksum + "#" + std::to_string(number); }
};

/// Result of the last comparison of a mesh with its field.
struct FieldFit {
  std::shared_ptr<const MeshField> field;  ///< field that was compared
  int disagreement = 0;                    ///< value of FieldMismatch::disagreement()
  bool settled = false;                    ///< whether no further comparison is due: the mesh has settled or is stuck
};

/// Sleep of a mesh (session/mesh_sleep.h).
struct SleepState {
  bool asleep = false;
  int settled_steps = 0;     ///< number of steps since something acted on it or a check found it moving
  int awake_steps = 0;       ///< number of steps since something acted on it
  std::uint64_t inputs = 0;  ///< input_digest() at the last command or when it fell asleep; 0: not computed
};

/// Mesh of a scene with the state of its simulation.
struct MeshItem {
  ItemId id = 0;
  std::string name;
  Colour colour{230, 160, 60};
  bool visible = true;
  bool locked = false;  ///< whether the pose is protected: no force, refinement or field changes it
  float opacity = 1;    ///< opacity in the 3D view, in (0, 1]
  int label = 1;        ///< value of the mesh's voxels in a saved label volume
  SegmentCode code{};   ///< codes that were chosen; empty: they follow from the name
  Seed seed;
  std::optional<MeshStart> start;
  std::optional<Reference> reference;
  ForceParameters parameters;

  SimplexMesh mesh;                       ///< pose when the engine was read last
  std::vector<Eigen::Vector3f> previous;  ///< positions one step before this pose
  std::vector<Vec4> shape;                ///< reference of shape memory; set when the mesh is made, refined or rebuilt
  std::vector<float> profiles;            ///< reference intensity profiles; empty until recorded
  RegionModel region;
  IntensityRange intensity_range;          ///< constraint of its field: other intensities are background
  MeshImages images;                       ///< in which its field is solved
  std::shared_ptr<const MeshModel> model;  ///< null: none
  /// The mesh starts from the shape of its model deformed by the first modes, deviations; empty: from the sphere.
  std::vector<float> start_modes;
  bool model_profiles = false;             ///< whether `profiles` are the mean ones of the model whenever it starts
  std::shared_ptr<const MeshField> field;  ///< field solved from the marks; null: not solved yet
  /// Set while the user has cancelled the update of `field` (is_update_cancelled()); null: not cancelled. Not saved, so
  /// that a reopened scene applies all its marks.
  std::shared_ptr<const CancelledUpdate> cancelled;
  SolverState solver;  ///< state of the solver at the time of the pose
  float edge_mm = 0;   ///< mean edge when it was made, refined or rebuilt, mm; 0: not measured yet
  int steps_at_level = 0;
  int final_vertices = 0;  ///< final number of vertices; 0: SimulationParameters::final_vertices
  bool rebuilt = false;    ///< whether it was rebuilt from its field or made from `start`: on its finest level
  FieldFit fit;
  SleepState sleep;

  /// MeshModel::identity() of the model; "" without one.
  std::string model_identity() const { return model ? model->identity() : ""; }
  /// Identity of the prior of its field: of the model, or of the mask of a network from which it starts; "" without
  /// one.
  std::string prior_identity() const;
  bool has_field() const { return field && !field->values.empty(); }
  /// Whether the image does not affect its field, which is the inside of `start` with the corrections of its marks.
  bool is_given() const { return start && !(start->error_mm > 0); }
};

/// Point, stroke or lasso that a user placed: a mark for the field of its mesh. A boundary point also attracts the
/// surface.
struct UserPoint {
  ItemId id = 0;
  ItemId mesh = 0;
  Eigen::Vector3d position_mm{0, 0, 0};
  MarkKind kind = MarkKind::Boundary;
  double radius_mm = 0;              ///< radius of the marked ball, or of the balls along a stroke, mm
  Eigen::Vector3d outward{0, 0, 0};  ///< boundary point: unit direction out of the object; 0: unknown
  /// Stroke or lasso: the vertices of its path after the first, which is `position_mm`, as offsets from it, mm. Only
  /// inside and outside points have one.
  std::vector<Eigen::Vector3d> path_mm{};

  /// Brush of a stroke of paint (inside) or of the eraser (outside). Such a stroke is no mark: it sets voxels exactly
  /// (session/paint.h).
  PaintBrush brush{};

  /// Whether it is applied in the same update as the point, or else the seed, before it, like the strokes of a box.
  bool continues = false;

  VoxelEdit edit = VoxelEdit::None;             ///< paint of `voxels`: the edit that determined them
  std::shared_ptr<const PaintVoxels> voxels{};  ///< voxels of a brush of shape Voxels; otherwise null
  bool local = false;                           ///< a mark that changes the object only near it (Mark::local)

  /// Lasso of inside or outside: unit normal of the slice of its closed contour, whose vertices are vertices_mm(); 0:
  /// not a lasso.
  Eigen::Vector3d lasso_normal{0, 0, 0};
  /// Strokes that a lasso stands for, determined by update_lasso(); null without a volume.
  std::shared_ptr<const std::vector<PromptStroke>> strokes{};

  bool is_paint() const { return brush.paints(); }
  bool is_lasso() const { return lasso_normal.squaredNorm() > 0; }
  bool is_stroke() const { return !path_mm.empty(); }
  /// All vertices of the path; one for a point.
  std::vector<Eigen::Vector3d> vertices_mm() const;
};

/// Whether a mesh is on its finest level: it was rebuilt, has its final number of vertices, or (unless the user refined
/// it) has a mean edge below SimulationParameters::finest_edge voxels. Uses the edge length measured when the mesh was
/// made, refined or rebuilt.
bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm);
/// Like is_finest() above, with the mean edge length of the current pose, mm.
bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm, double mean_edge_mm);

/// View of the user when the scene was saved.
struct SavedView {
  Eigen::Vector3d crosshair_mm{0, 0, 0};
  double window = 1, level = 0;  ///< level - window/2 is shown black, level + window/2 white
  std::string active_mesh;       ///< name of the active mesh; "": none
};

/// Labels of names, so that a structure has the same label in every segmentation.
struct LabelNumbers {
  std::string preset;                  ///< name of a label preset, or path of its file; "": none
  std::map<std::string, int> by_name;  ///< labels of the preset, and of earlier meshes of the scene
};

/// Contents of a scene file: meshes, points, measurements, layers, parameters, and the path of the volume.
struct Scene {
  std::string volume_path;
  int volume_number = 1;                 ///< number of the volume in a 4D file, from 1
  std::string volume_checksum;           ///< checksum of the image (io/volume/volume_checksum.h); "": unknown
  std::string volume_series;             ///< UID of the series in a DICOM folder; empty: the largest series
  Preprocessing volume_preprocessing{};  ///< filters of the volume, whose file stays as it is
  std::vector<MeshItem> meshes;
  std::vector<UserPoint> points;
  std::vector<Measurement> measurements;
  std::vector<LayerItem> layers;  ///< further images, in the order in which they are drawn
  SimulationParameters simulation;
  std::optional<SavedView> view;
  int steps = 0;  ///< default number of steps of simplexseg-cli run; 0: until all meshes settle
  ForceParameters forces = default_force_parameters();  ///< parameters of a new mesh
  LabelNumbers labels;

  const MeshItem* find_mesh(ItemId id) const;
  MeshItem* find_mesh(ItemId id);
  const MeshItem* find_mesh(const std::string& name) const;
  const UserPoint* find_point(ItemId id) const;
  const Measurement* find_measurement(ItemId id) const;
  const LayerItem* find_layer(ItemId id) const;
};

}  // namespace simplexseg
