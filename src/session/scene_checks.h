// SPDX-License-Identifier: Apache-2.0
// Checks of scenes and of the values of commands. Each throws Error with a message of one line.
#pragma once
#include <Eigen/Core>
#include <string>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Throws unless the value lies in the parameter's range; throws for NaN. `owner`: force or segmentation to which the
/// parameter belongs, for the message.
void check_value(const ParameterInfo& info, float value, const std::string& owner);
/// Throws unless centre and radius of the sphere are finite, the radius is above 0 and the centre lies in the volume,
/// if there is a volume. `name`: name of the mesh, for the message.
void check_seed(const Seed& seed, const std::string& name, const Volume& volume);
/// Throws unless every coordinate of a point is finite and at most 1e9 mm in magnitude.
void check_position(const Eigen::Vector3d& position_mm);
/// Throws unless the radius of the ball that a point marks is above 0 and at most 1000 mm.
void check_radius(double radius_mm);
/// Throws unless a point of this kind may have this position: inside and outside points must lie in the volume.
void check_mark(MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume);
/// Throws unless a point of this kind may have this path (UserPoint::path_mm): boundary points have none, others at
/// most 100,000 vertices within 1e9 mm.
void check_path(MarkKind kind, const std::vector<Eigen::Vector3d>& path_mm);
/// Throws for a stroke of marks that is longer than 2,000 of its radii.
void check_stroke(const std::vector<Eigen::Vector3d>& path_mm, double radius_mm);
/// Throws for a mesh whose pose is protected.
void refuse_locked(const MeshItem& item);
/// Throws unless the lower limit of a range is below the upper one, and for a range of a mesh that starts from labels
/// or a mesh.
void check_range(const MeshItem& item, const IntensityRange& range);
/// Throws for a model that was not read, and for a model (null: none) of a mesh that starts from labels or a mesh.
void check_model(const MeshItem& item, const MeshModel* model);
/// Throws for a mesh that cannot start from the mask of a network: it is locked or has a model.
void check_network_start(const MeshItem& item);
/// Throws for start modes (MeshItem::start_modes) without a model, more than it has, or out of range.
void check_start_modes(const MeshItem& item);
/// Throws for a mesh that does not start from the shape of a model, whose profiles it therefore cannot have
/// (MeshItem::model_profiles).
void check_model_profiles(const MeshItem& item);
/// Throws unless paint belongs to an inside or outside point and has what its brush needs: a radius up to 100 mm, a
/// unit normal, a thickness, three vertices or voxels.
void check_paint(const UserPoint& point);
/// Throws unless DICOM can store the codes, or they are empty. `name`: name of the mesh, for the message.
void check_code(const SegmentCode& code, const std::string& name);
/// Throws unless every name has a label from 1 to 65535, and no two names the same.
void check_labels(const std::map<std::string, int>& by_name);
/// Throws unless the points define a measurement of this kind (defect_of()).
void check_measurement(MeasurementKind kind, const std::vector<Eigen::Vector3d>& points_mm);
/// Checks values, seeds, meshes, points, measurements, layers and ids of a scene before it is opened on the volume.
/// Assigns ids to items that have none, and determines the strokes of lassos. Returns the next unused id.
ItemId check_scene(Scene& scene, const Volume& volume);

}  // namespace simplexseg
