// SPDX-License-Identifier: Apache-2.0
// Strokes: prompts that a user draws as curves.
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "field/marks.h"

namespace simplexseg {

/// Stroke that stands for a part of another prompt: a box or a lasso.
struct PromptStroke {
  MarkKind kind;
  std::vector<Eigen::Vector3d> path_mm;
  double radius_mm;
};

/// Marks of a stroke: balls along its path, with a distance of at most one radius. All but the first have
/// MarkLink::Stroke. `path_mm`: polyline with at least one point; `radius_mm` > 0.
std::vector<Mark> marks_of_stroke(MarkKind kind, std::span<const Eigen::Vector3d> path_mm, double radius_mm);

/// Marks of the strokes that one prompt stands for, applied in one update. `link`: of the first mark.
std::vector<Mark> marks_of_strokes(std::span<const PromptStroke> strokes, MarkLink link = MarkLink::None);

/// Number of prompts: marks, where a stroke counts once.
int prompt_count(std::span<const Mark> marks);
/// Number of the balls of all prompts: two for a boundary mark, and one for a stroke.
int prompt_ball_count(std::span<const Mark> marks);

}  // namespace simplexseg
