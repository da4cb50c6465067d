// SPDX-License-Identifier: Apache-2.0
// What a user says about an object: the only thing that the evidence field learns from besides the image.
#pragma once
#include <Eigen/Core>
#include <cstdint>

namespace simplexseg {

enum class MarkKind : std::uint8_t {
  Inside,    ///< a ball that belongs to the object: the seed, or a dot
  Outside,   ///< a ball that does not
  Boundary,  ///< a place on the surface: a dot inside on one side, a dot outside on the other
};

struct Mark {
  MarkKind kind = MarkKind::Inside;
  Eigen::Vector3d position_mm{0, 0, 0};  ///< patient frame (LPS)
  double radius_mm = 0;                  ///< > 0; the nearest voxel is marked however small it is
  Eigen::Vector3d outward{0, 0, 0};      ///< of a boundary mark alone: points out of the object, any length > 0

  bool operator==(const Mark&) const = default;
};

}  // namespace simplexseg
