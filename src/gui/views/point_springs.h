// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class Session;

/// Boundary point and the vertex that it pulls: the nearest vertex, as in AttractionForce.
struct PointSpring {
  ItemId point = 0;
  Eigen::Vector3d vertex_mm;
  double reach_mm = 0;  ///< approximate radius of the part of the surface that moves with the vertex
};

/// Springs of all boundary points whose mesh is visible, not locked, and has a weight above 0 of the force Attraction.
class PointSprings {
 public:
  /// Updates the springs when the pose has changed. There are no springs while the simulation runs on a device, because
  /// its poses are not read back.
  void update(const Session& session, bool running);
  const std::vector<PointSpring>& all() const { return springs_; }
  /// Spring of a point; null if it has none.
  const PointSpring* find(ItemId point) const;

 private:
  std::vector<PointSpring> springs_;
  std::uint64_t revision_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
