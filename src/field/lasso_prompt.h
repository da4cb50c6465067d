// SPDX-License-Identifier: Apache-2.0
// Lassos: closed contours around a part of an object, or of its background, in a slice.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "field/stroke.h"

namespace simplexseg {

struct VolumeGeometry;

/// Strokes that a lasso stands for. `kind` Inside: inside strokes in the contour and an outside stroke around it, so
/// that the border of the object lies on the contour; Outside: outside strokes in the contour alone. Strokes follow the
/// contour at 2 voxels with a radius of 1 voxel, and in its interior at 6, 14, 30 ... voxels with radii of 2, 4, 8 ...
/// voxels (docs/adr/0053-lasso.md). `starts`: a segmentation starts from it; the outside stroke is then at 5 voxels, as
/// around a box (docs/adr/0055-lasso-item.md). Throws Error if the contour encloses no place of the volume that is half
/// a voxel away from it.
std::vector<PromptStroke> prompt_of_lasso(MarkKind kind, std::span<const Eigen::Vector3d> contour_mm,
                                          const Eigen::Vector3d& normal, const VolumeGeometry& volume,
                                          bool starts = false);

/// Seed of an object that starts from a lasso around it: in the enclosed place farthest from the contour, with 0.4 of
/// that distance as radius, at least 1 voxel (docs/adr/0055-lasso-item.md). Throws Error if the contour has fewer than
/// three vertices or encloses no place of the volume.
Mark seed_of_lasso(std::span<const Eigen::Vector3d> contour_mm, const Eigen::Vector3d& normal,
                   const VolumeGeometry& volume);

}  // namespace simplexseg
