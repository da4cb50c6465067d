// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QElapsedTimer>
#include <QString>

#include "session/scene.h"

class QWheelEvent;

namespace simplexseg {

class Workbench;

/// Wheel gestures over a point, in slices and in 3D.
class PointWheel {
 public:
  explicit PointWheel(Workbench& workbench) : workbench_(workbench) {}
  /// Returns true if the wheel changes `point`. False shortly after another use of the wheel, because a point may pass
  /// under the mouse while the user scrolls through slices.
  bool handles(ItemId point) const;
  /// Changes reach or strength according to the table of bindings. `slices`: true in a slice, false in 3D.
  void turn(ItemId point, const QWheelEvent& event, bool slices);
  /// Records that the wheel was used for something else.
  void record_other_use() { other_use_.start(); }

 private:
  void change_reach(const UserPoint& point, int notches, bool continues);
  void change_strength(const UserPoint& point, int notches, bool continues);

  Workbench& workbench_;
  ItemId last_ = 0;
  double degrees_ = 0;  ///< rotation since the last whole notch, degrees
  QElapsedTimer last_turn_, other_use_;
};

/// Description of a point, such as "Inside mark, radius 5.2 mm"; empty without a point.
QString point_text(const Workbench& workbench, ItemId point);

}  // namespace simplexseg
