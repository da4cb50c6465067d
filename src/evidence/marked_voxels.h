// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "evidence/marks.h"
#include "evidence/run_jobs.h"
#include "image/distance_map.h"
#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// What is known of a voxel before anything is solved.
enum class Known : std::uint8_t {
  Nothing,
  Inside,
  Outside,
  FarBorder,   ///< side of the box within the volume: outside
  VolumeEdge,  ///< side of the box that is the volume's: outside for the solver, though an object may be cut there
  NotFinite,   ///< conducts nothing; outside
};

/// True where the field is given rather than solved.
constexpr bool is_held(Known known) { return known != Known::Nothing; }

/// From a boundary mark to its outside dot, mm; its inside dot lies as far on the other side. The two touch at the
/// mark: with a gap between them what a mark says of the layer beside it, which is what was wrong, is little. 0 for
/// other marks.
Eigen::Vector3d dot_step(const Mark& mark);

/// All voxels of a box, later marks over earlier ones, marks over `others` (objects of others on the volume's grid, or
/// null) and over the box's sides. `finite`: 0 where the image is not; empty: it is everywhere. A mark holds the voxels
/// whose centres lie in its ball, and the nearest one.
std::vector<Known> known_voxels(const VolumeGeometry& geometry, const VoxelBox& box,
                                std::span<const std::uint8_t> finite, std::span<const Mark> marks, const Mask* others);

/// Their marks alone, over what is known.
void paint_marks(const VolumeGeometry& geometry, const VoxelBox& box, std::span<const Mark> marks,
                 std::vector<Known>& known);

/// For every voxel of a box the square of the distance, in mm, to the nearest of these places; 1e12 without any.
std::vector<float> squared_distances(const VolumeGeometry& geometry, const VoxelBox& box,
                                     std::span<const Eigen::Vector3d> places_mm, const RunJobs& run);

}  // namespace simplexseg
