// SPDX-License-Identifier: Apache-2.0
// Marks: the prompts of an evidence field.
#pragma once
#include <Eigen/Core>
#include <cstdint>

namespace simplexseg {

enum class MarkKind : std::uint8_t {
  Inside,    ///< ball in the object: seed or inside mark
  Outside,   ///< ball outside the object
  Boundary,  ///< point of the surface: an inside ball on one side and an outside ball on the other
};

struct Mark {
  MarkKind kind = MarkKind::Inside;
  Eigen::Vector3d position_mm{0, 0, 0};  ///< patient frame (LPS)
  double radius_mm = 0;                  ///< > 0; the nearest voxel is marked whatever the radius
  Eigen::Vector3d outward{0, 0, 0};      ///< boundary marks only: direction out of the object, any length > 0
  bool continues = false;                ///< whether it belongs to the same stroke as the mark before it

  bool operator==(const Mark&) const = default;
};

}  // namespace simplexseg
