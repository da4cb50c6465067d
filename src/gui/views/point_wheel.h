// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QElapsedTimer>
#include <QString>

#include "session/scene.h"

class QWheelEvent;

namespace simplexseg {

class Workbench;

/// What the wheel does over a point, in slices and in 3D.
class PointWheel {
 public:
  explicit PointWheel(Workbench& workbench) : workbench_(workbench) {}
  /// Whether a turn over `point` is for that: not while slices go by under the mouse, which may bring a point under it.
  bool takes(ItemId point) const;
  /// Changes reach or strength, as the table of bindings says (`slices`: of where it is turned).
  void turn(ItemId point, const QWheelEvent& event, bool slices);
  /// The wheel did something else.
  void passed_by() { elsewhere_.start(); }

 private:
  void change_reach(const UserPoint& point, int notches, bool continues);
  void change_strength(const UserPoint& point, int notches, bool continues);

  Workbench& workbench_;
  ItemId last_ = 0;
  double degrees_ = 0;  ///< turned since the last whole notch
  QElapsedTimer since_, elsewhere_;
};

/// "Inside: ball of 5.2 mm", "Boundary: strength 2, reach 5 rings": for the view under the mouse. Empty for no point.
QString words_of_point(const Workbench& workbench, ItemId point);

}  // namespace simplexseg
