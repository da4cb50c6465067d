// SPDX-License-Identifier: Apache-2.0
// Kinds and radii of points, ranges of intensities and kinds of measurements, in scene files and logs.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// Name of a kind of point: "inside", "outside" or "boundary".
const char* name_of(MarkKind kind);
/// Kind of point with a name; nullopt if the name is unknown.
std::optional<MarkKind> find_point_kind(const std::string& name);
MarkKind read_point_kind(const JsonInput& input);
/// Reads a radius in mm. Throws Error unless it is above 0 and at most kMaxMillimetres.
double read_radius(const JsonInput& input);
/// Reads the vertices of a path (UserPoint::path_mm): a list of lists of three numbers.
std::vector<Eigen::Vector3d> read_path(const JsonInput& input);
/// Reads a range of intensities (range_json()). Throws Error unless `low` is below `high`.
IntensityRange read_range(const JsonInput& input);
/// Reads paint into `brush` and `edit`: `normal` and `thickness_mm` of a disc or, with `contour`, of a contour; neither
/// for a ball. Returns its set of voxels, or null without one.
std::shared_ptr<const PaintVoxels> read_paint(const JsonInput& input, PaintBrush& brush, VoxelEdit& edit);
/// Reads the name of an edit.
VoxelEdit read_voxel_edit(const JsonInput& input);
/// Reads a set of painted voxels (voxels_json()).
std::shared_ptr<const PaintVoxels> read_voxels(const JsonInput& input);
MeasurementKind read_measurement_kind(const JsonInput& input);

}  // namespace simplexseg
