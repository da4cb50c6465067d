// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class Session;

/// What a boundary point pulls: the vertex nearest to it, as AttractionForce binds it.
struct PointSpring {
  ItemId point = 0;
  Eigen::Vector3d vertex_mm;
  double reach_mm = 0;  ///< about as far as the surface around the vertex follows
};

/// The springs of all boundary points whose mesh is shown and has the force Attraction.
class PointSprings {
 public:
  /// Finds them anew where the pose has changed. A device that is running is not asked for its poses: none are known
  /// then.
  void update(const Session& session, bool running);
  const std::vector<PointSpring>& all() const { return springs_; }
  /// Null where it has none.
  const PointSpring* of(ItemId point) const;

 private:
  std::vector<PointSpring> springs_;
  std::uint64_t revision_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
