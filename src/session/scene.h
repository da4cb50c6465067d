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

using ItemId = std::uint32_t;  ///< id of a mesh or point, unique in a session; 0: none

/// Reference segmentation that reports compare a mesh with.
struct Reference {
  std::string labels;           ///< path as in the scene file
  std::optional<double> value;  ///< label; none: every voxel that is not 0
};

/// Sphere from which a mesh starts.
struct Seed {
  Eigen::Vector3d centre_mm{0, 0, 0};
  double radius_mm = 10;
};

/// Start of a mesh other than the sphere of its seed: labels, or a mesh of another program. A reset returns to it.
struct MeshStart {
  std::string path;             ///< path of a label volume or a mesh, as in the scene file
  std::optional<double> value;  ///< label; none: every voxel that is not 0
  int part = 0;                 ///< connected component, numbered by size from 1, the largest; 0: all
  std::shared_ptr<const SimplexMesh> mesh;
};

/// Result of the last comparison of a mesh with its field.
struct FieldFit {
  std::shared_ptr<const MeshField> field;  ///< field that was compared
  int disagreement = 0;                    ///< FieldMismatch::disagreement()
  bool settled = false;                    ///< agrees with the field or was rebuilt from it: no further comparison
};

/// Mesh of a scene with the state of its simulation.
struct MeshItem {
  ItemId id = 0;
  std::string name;
  Colour colour{230, 160, 60};
  bool visible = true;
  bool locked = false;  ///< keeps its pose: no force, refinement or field changes it
  float opacity = 1;    ///< in the 3D view, in (0, 1]
  int label = 1;        ///< value of the mesh's voxels in a saved label volume
  Seed seed;
  std::optional<MeshStart> start;
  std::optional<Reference> reference;
  ForceParameters parameters;

  SimplexMesh mesh;                       ///< pose as of the last advance
  std::vector<Eigen::Vector3f> previous;  ///< positions one step earlier
  std::vector<Vec4> shape;                ///< reference of shape memory; set when the mesh is made or refined
  std::vector<float> profiles;            ///< reference intensity profiles; empty until recorded
  RegionModel region;
  std::shared_ptr<const MeshField> field;  ///< solved from its marks; null: not yet
  SolverState solver;                      ///< state of the solver at this level, as of the pose
  float edge_mm = 0;                       ///< mean edge length when it was made or refined; 0: not measured yet
  int steps_at_level = 0;
  int final_vertices = 0;  ///< 0: SimulationParameters::final_vertices
  bool rebuilt = false;    ///< rebuilt from its field or made from labels, at its finest level
  FieldFit fit;

  bool has_field() const { return field && !field->values.empty(); }
};

/// Point that a user placed: a mark for the field of its mesh. A boundary point also attracts the mesh.
struct UserPoint {
  ItemId id = 0;
  ItemId mesh = 0;
  Eigen::Vector3d position_mm{0, 0, 0};
  MarkKind kind = MarkKind::Boundary;
  double radius_mm = 0;              ///< radius of the marked ball
  Eigen::Vector3d outward{0, 0, 0};  ///< boundary point: unit direction out of the object; 0: unknown
};

/// Whether a mesh is on its finest level: it has its final number of vertices, or (unless the user refined it) edges of
/// voxel size. Uses the edge length from when the mesh was made or refined.
bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm);
/// Like is_finest() above, with the mean edge length of the current pose.
bool is_finest(const MeshItem& item, const SimulationParameters& simulation, double voxel_mm, double mean_edge_mm);

/// View of the user when the scene was saved.
struct SavedView {
  Eigen::Vector3d crosshair_mm{0, 0, 0};
  double window = 1, level = 0;  ///< intensities level - window/2 and level + window/2 are black and white
  std::string active_mesh;       ///< name; "": none
};

/// Contents of a scene file: meshes, points, parameters, and the path of the volume.
struct Scene {
  std::string volume_path;
  int volume_number = 1;        ///< volume of a 4D file, from 1
  std::string volume_checksum;  ///< checksum of the image (io/volume/volume_checksum.h); "": unknown
  std::string volume_series;    ///< UID of the series in a DICOM folder; empty: the largest
  std::vector<MeshItem> meshes;
  std::vector<UserPoint> points;
  SimulationParameters simulation;
  std::optional<SavedView> view;
  int steps = 0;  ///< default number of steps of simplexseg-cli run; 0: until all meshes settle
  ForceParameters forces = default_force_parameters();  ///< parameters of a new mesh

  const MeshItem* find_mesh(ItemId id) const;
  MeshItem* find_mesh(ItemId id);
  const MeshItem* find_mesh(const std::string& name) const;
  const UserPoint* find_point(ItemId id) const;
};

}  // namespace simplexseg
