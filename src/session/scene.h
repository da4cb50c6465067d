// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/colour.h"
#include "forces/parameters.h"
#include "forces/region_model.h"
#include "mesh/simplex_mesh.h"
#include "session/mesh_field.h"
#include "step/engine.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

using ItemId = std::uint32_t;  ///< a mesh's or a point's; never used twice in a session; 0 is none

/// Truth that a report compares a mesh with.
struct Reference {
  std::string labels;           ///< path, as the scene file has it
  std::optional<double> value;  ///< label; none: every voxel that is not 0
};

/// The sphere that a mesh starts as.
struct Seed {
  Eigen::Vector3d centre_mm{0, 0, 0};
  double radius_mm = 10;
};

/// What a mesh starts from, and goes back to, instead of the sphere of its seed: labels, or a mesh of another program.
struct MeshStart {
  std::string path;             ///< of a label volume or a mesh, as the scene file has it
  std::optional<double> value;  ///< label; none: every voxel that is not 0
  int part = 0;                 ///< connected part of it, from 1, the largest; 0: all
  std::shared_ptr<const SimplexMesh> mesh;
};

/// How well a mesh followed its field when that was looked at last.
struct FieldFit {
  std::shared_ptr<const MeshField> field;  ///< that it was compared with
  int disagreement = 0;                    ///< FieldDistance::disagreement()
  bool settled = false;                    ///< it follows, or was made of the field: no need to look again
};

/// One mesh of a scene, with all that its simulation has as state.
struct MeshItem {
  ItemId id = 0;
  std::string name;
  Colour colour{230, 160, 60};
  bool visible = true;
  bool locked = false;  ///< it keeps its pose: no force, refinement or field moves it
  float opacity = 1;    ///< in the 3D view, above 0 and up to 1
  int label = 1;        ///< that its voxels have in a saved segmentation
  Seed seed;
  std::optional<MeshStart> start;
  std::optional<Reference> reference;
  ForceParameters parameters;

  SimplexMesh mesh;                       ///< pose as of the last advance
  std::vector<Eigen::Vector3f> previous;  ///< positions one step earlier
  std::vector<Vec4> shape;                ///< shape memory's reference; taken when the mesh was made or refined
  std::vector<float> profiles;            ///< reference intensity profiles; empty until recorded
  RegionModel region;
  std::shared_ptr<const MeshField> field;  ///< learned from its marks; null: not yet
  SolverState solver;                      ///< what its solver had learnt at this level, as of the pose
  float edge_mm = 0;                       ///< mean edge when it was made or refined; 0: not measured yet
  int steps_at_level = 0;
  int final_vertices = 0;  ///< 0: the simulation's
  bool rebuilt = false;    ///< made of its field or of labels: as fine as it is to be
  FieldFit fit;

  bool has_field() const { return field && !field->values.empty(); }
};

/// What a user placed: what it says of the object of its mesh. A boundary point attracts the mesh besides.
struct UserPoint {
  ItemId id = 0;
  ItemId mesh = 0;
  Eigen::Vector3d position_mm{0, 0, 0};
  MarkKind kind = MarkKind::Boundary;
  double radius_mm = 0;              ///< of the ball that it marks
  Eigen::Vector3d outward{0, 0, 0};  ///< of a boundary point: the way out of the object, unit; 0: not known
};

/// Whether a mesh is as fine as it is to end: it has the vertices that are wanted, or (unless the user refined it)
/// edges of voxel size.
bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm);
/// The same by the mean edge of a pose, where that above goes by the one that the mesh was made or refined with.
bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm, double mean_edge_mm);

/// Where a user was in a volume when the scene was saved.
struct SavedView {
  Eigen::Vector3d crosshair_mm{0, 0, 0};
  double window = 1, level = 0;  ///< intensities level -+ window/2 are black and white
  std::string active_mesh;       ///< by its name; "": none
};

/// All that is saved: meshes, points, parameters. The volume is named alone.
struct Scene {
  std::string volume_path;
  int volume_number = 1;        ///< which volume of a 4D file, from 1
  std::string volume_checksum;  ///< of the volume that the meshes were made on (io/volume_checksum.h); "": not known
  std::string volume_series;    ///< UID of the series to be taken of a DICOM folder; empty: the largest
  std::vector<MeshItem> meshes;
  std::vector<UserPoint> points;
  SimulationParameters simulation;
  std::optional<SavedView> view;
  int steps = 0;  ///< that the headless program runs unless told otherwise; 0: until rest
  ForceParameters forces = default_force_parameters();  ///< that a mesh starts with which is like none other

  const MeshItem* find_mesh(ItemId id) const;
  MeshItem* find_mesh(ItemId id);
  const MeshItem* find_mesh(const std::string& name) const;
  const UserPoint* find_point(ItemId id) const;
};

}  // namespace simplexseg
