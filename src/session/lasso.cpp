// SPDX-License-Identifier: Apache-2.0
#include "session/lasso.h"

#include <cmath>

#include "core/error.h"
#include "core/expect.h"
#include "field/lasso_prompt.h"
#include "image/volume.h"
#include "session/scene_checks.h"

namespace simplexseg {

UserPoint lasso_of(ItemId mesh, MarkKind kind, std::span<const Eigen::Vector3d> contour_mm,
                   const Eigen::Vector3d& normal) {
  SIMPLEXSEG_EXPECT(!contour_mm.empty());
  UserPoint point{0, mesh, contour_mm[0], kind};
  for (const Eigen::Vector3d& vertex : contour_mm.subspan(1)) point.path_mm.emplace_back(vertex - contour_mm[0]);
  point.lasso_normal = normal;
  return point;
}

void update_lasso(UserPoint& point, const Volume& volume) {
  check_position(point.position_mm);
  check_path(point.kind, point.path_mm);
  if (point.is_paint() || point.kind == MarkKind::Boundary)
    throw Error("the lasso", "it is neither inside nor outside", "correct its kind");
  if (!(std::abs(point.lasso_normal.norm() - 1) < 1e-6))
    throw Error("the lasso", "its normal is not a unit vector", "correct the normal");
  constexpr double kMostMm = 0.1;  // a contour of the window deviates by rounding alone
  for (const Eigen::Vector3d& offset : point.path_mm)
    if (!(std::abs(offset.dot(point.lasso_normal)) <= kMostMm))
      throw Error("the lasso", "its contour does not lie in the plane of its normal", "draw it in one slice");
  point.strokes = nullptr;
  if (volume.empty()) return;
  point.strokes = std::make_shared<const std::vector<PromptStroke>>(
      prompt_of_lasso(point.kind, point.vertices_mm(), point.lasso_normal, volume.geometry(), point.continues));
}

int stroke_count(const UserPoint& point) { return point.strokes ? static_cast<int>(point.strokes->size()) : 0; }

}  // namespace simplexseg
