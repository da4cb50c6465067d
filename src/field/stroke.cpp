// SPDX-License-Identifier: Apache-2.0
#include "field/stroke.h"

#include <algorithm>
#include <cmath>

#include "core/expect.h"

namespace simplexseg {

std::vector<Mark> marks_of_stroke(MarkKind kind, std::span<const Eigen::Vector3d> path_mm, double radius_mm) {
  SIMPLEXSEG_EXPECT(!path_mm.empty() && radius_mm > 0);
  double length_mm = 0;
  for (std::size_t p = 1; p < path_mm.size(); ++p) length_mm += (path_mm[p] - path_mm[p - 1]).norm();
  const int balls = 1 + static_cast<int>(std::ceil(length_mm / radius_mm));
  std::vector<Mark> marks;
  std::size_t segment = 1;       // path_mm[segment - 1] to path_mm[segment]
  double before_segment_mm = 0;  // length of the path before it
  for (int b = 0; b < balls; ++b) {
    const double at_mm = balls == 1 ? 0 : length_mm * b / (balls - 1);
    Eigen::Vector3d position_mm = path_mm.back();
    for (; segment < path_mm.size(); ++segment) {
      const Eigen::Vector3d along = path_mm[segment] - path_mm[segment - 1];
      const double segment_mm = along.norm(), rest_mm = at_mm - before_segment_mm;
      if (rest_mm <= segment_mm) {
        position_mm = path_mm[segment - 1];
        if (segment_mm > 0) position_mm += rest_mm / segment_mm * along;
        break;
      }
      before_segment_mm += segment_mm;
    }
    marks.push_back({kind, position_mm, radius_mm, {0, 0, 0}, b > 0 ? MarkLink::Stroke : MarkLink::None});
  }
  return marks;
}

std::vector<Mark> marks_of_strokes(std::span<const PromptStroke> strokes, MarkLink link) {
  std::vector<Mark> all;
  for (const PromptStroke& stroke : strokes) {
    std::vector<Mark> marks = marks_of_stroke(stroke.kind, stroke.path_mm, stroke.radius_mm);
    marks[0].link = all.empty() ? link : MarkLink::Update;
    all.insert(all.end(), marks.begin(), marks.end());
  }
  return all;
}

int prompt_count(std::span<const Mark> marks) {
  return static_cast<int>(std::ranges::count_if(marks, [](const Mark& mark) { return mark.link != MarkLink::Stroke; }));
}

int prompt_ball_count(std::span<const Mark> marks) {
  return prompt_count(marks) + static_cast<int>(std::ranges::count(marks, MarkKind::Boundary, &Mark::kind));
}

}  // namespace simplexseg
