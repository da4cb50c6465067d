// SPDX-License-Identifier: Apache-2.0
#include "gui/views/point_springs.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "forces/attraction.h"
#include "session/session.h"

namespace simplexseg {

void PointSprings::update(const Session& session, bool running) {
  if (revision_ == session.revision()) return;
  springs_.clear();
  const std::vector<UserPoint>& points = session.scene_without_poses().points;
  const bool any = std::any_of(points.begin(), points.end(),
                               [](const UserPoint& point) { return point.kind == MarkKind::Boundary; });
  const bool on_device = std::strcmp(session.engine().backend(), "cpu") != 0;
  if (!any || (running && on_device)) return;
  const Scene& scene = session.scene();
  for (const UserPoint& point : scene.points) {
    const MeshItem* item = scene.find_mesh(point.mesh);
    if (point.kind != MarkKind::Boundary || !item || !item->visible || item->locked) continue;
    if (!(item->parameters.weight(ForceId::Attraction) > 0)) continue;
    const Eigen::Vector3f at = point.position_mm.cast<float>();
    float best = std::numeric_limits<float>::infinity();
    PointSpring spring{point.id, point.position_mm, 0};
    for (const Eigen::Vector3f& p : item->mesh.positions) {
      const float distance = (p - at).squaredNorm();
      if (distance < best) best = distance, spring.vertex_mm = p.cast<double>();
    }
    const float rings = item->parameters.values[static_cast<std::size_t>(ForceId::Attraction)][AttractionForce::order];
    spring.reach_mm = rings * item->edge_mm;
    springs_.push_back(spring);
  }
  revision_ = session.revision();
}

const PointSpring* PointSprings::find(ItemId point) const {
  const auto found =
      std::find_if(springs_.begin(), springs_.end(), [&](const PointSpring& s) { return s.point == point; });
  return found == springs_.end() ? nullptr : &*found;
}

}  // namespace simplexseg
