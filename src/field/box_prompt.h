// SPDX-License-Identifier: Apache-2.0
// Boxes: rectangles around an object in a slice, from which a segmentation starts.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "field/marks.h"
#include "field/stroke.h"

namespace simplexseg {

struct VolumeGeometry;

/// Corners of a rectangle in a slice, in order, mm. Neighbouring sides are perpendicular and longer than 0.
using BoxCorners = std::array<Eigen::Vector3d, 4>;

/// Prompts that a box stands for: a seed in its centre, with 0.35 of the half shorter side; a stroke of that radius
/// along the longer side, unless it is short; and strokes around the box, 5 voxels away. Origin of the values:
/// docs/adr/0049-box.md.
struct BoxPrompt {
  Mark seed;
  std::vector<PromptStroke> strokes;

  /// Marks of the seed and of all strokes, in this order, applied in one update.
  std::vector<Mark> marks() const;
};
/// Sides of the box beyond which the volume ends have no stroke. Throws Error if its centre lies outside the volume or
/// a side has no length.
BoxPrompt prompt_of_box(const BoxCorners& corners, const VolumeGeometry& volume);

}  // namespace simplexseg
