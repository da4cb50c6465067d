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

/// Relation of a mark to the one before it.
enum class MarkLink : std::uint8_t {
  None,    ///< a prompt of its own
  Update,  ///< a prompt of its own that is applied in the same update, such as a stroke of a box
  Stroke,  ///< part of the same stroke
};

struct Mark {
  MarkKind kind = MarkKind::Inside;
  Eigen::Vector3d position_mm{0, 0, 0};  ///< patient frame (LPS)
  double radius_mm = 0;                  ///< > 0; the nearest voxel is marked whatever the radius
  Eigen::Vector3d outward{0, 0, 0};      ///< boundary marks only: direction out of the object, any length > 0
  MarkLink link = MarkLink::None;
  bool local = false;  ///< changes the field only near it (docs/adr/0056-local-marks.md)

  bool operator==(const Mark&) const = default;
};

}  // namespace simplexseg
