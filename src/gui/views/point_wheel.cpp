// SPDX-License-Identifier: Apache-2.0
#include "gui/views/point_wheel.h"

#include <QCoreApplication>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "forces/attraction.h"
#include "gui/input/bindings.h"
#include "gui/look/point_style.h"
#include "gui/look/qt_text.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr int kOneTurnMs = 1000;     // successive notches closer than this are one action
constexpr int kOtherUseMs = 600;     // time after another use of the wheel in which points do not change
constexpr double kRadiusStep = 1.1;  // factor per notch
constexpr float kStrengthStep = 1.15f;

const ParameterInfo& info_of(int parameter) { return AttractionForce::parameters[parameter]; }

float value_of(const MeshItem& item, int parameter) {
  return item.parameters.values[static_cast<std::size_t>(ForceId::Attraction)][static_cast<std::size_t>(parameter)];
}

QString wheel_text(const char* text) { return QCoreApplication::translate("PointWheel", text); }

}  // namespace

bool PointWheel::handles(ItemId point) const {
  const UserPoint* item = workbench_.scene().find_point(point);
  return item && !item->is_lasso() && !(other_use_.isValid() && other_use_.elapsed() < kOtherUseMs);
}

void PointWheel::turn(ItemId point, const QWheelEvent& event, bool slices) {
  const UserPoint* item = workbench_.scene().find_point(point);
  if (!item) return;
  // Some desktops report a horizontal wheel while Shift is held.
  const QPoint angle = event.angleDelta();
  degrees_ += (angle.y() != 0 ? angle.y() : angle.x()) / 8.0;
  const int notches = static_cast<int>(degrees_ / 15);
  degrees_ -= 15.0 * notches;
  if (notches == 0) return;
  const bool continues = last_ == point && last_turn_.isValid() && last_turn_.elapsed() < kOneTurnMs;
  last_ = point;
  last_turn_.start();
  const std::optional<Act> act = gesture(slices ? Where::Slices : Where::Space, Mouse::WheelOnPoint, event.modifiers());
  if (act == Act::PointReach) change_reach(*item, notches, continues);
  if (act == Act::PointStrength) change_strength(*item, notches, continues);
}

void PointWheel::change_reach(const UserPoint& point, int notches, bool continues) {
  if (point.kind != MarkKind::Boundary) {
    const double least_mm = 0.5 * workbench_.session().volume().geometry().spacing_mm.minCoeff();
    const double radius_mm = std::clamp(point.radius_mm * std::pow(kRadiusStep, notches), least_mm, 200.0);
    workbench_.apply(ResizePoint{point.id, radius_mm, continues});
    return;
  }
  const MeshItem* item = workbench_.scene().find_mesh(point.mesh);
  const ParameterInfo& info = info_of(AttractionForce::order);
  const float rings = value_of(*item, AttractionForce::order) + static_cast<float>(notches);
  workbench_.apply(SetForceParameter{point.mesh, ForceId::Attraction, AttractionForce::order,
                                     std::clamp(rings, info.minimum, info.maximum), continues});
}

void PointWheel::change_strength(const UserPoint& point, int notches, bool continues) {
  if (point.kind != MarkKind::Boundary) return;
  const MeshItem* item = workbench_.scene().find_mesh(point.mesh);
  const ParameterInfo& info = info_of(AttractionForce::weight);
  const float weight =
      std::max(value_of(*item, AttractionForce::weight), 0.1f) * std::pow(kStrengthStep, static_cast<float>(notches));
  workbench_.apply(SetForceParameter{point.mesh, ForceId::Attraction, AttractionForce::weight,
                                     std::clamp(weight, 0.1f, info.maximum), continues});
}

QString point_text(const Workbench& workbench, ItemId point) {
  const UserPoint* item = workbench.scene().find_point(point);
  const MeshItem* mesh = item ? workbench.scene().find_mesh(item->mesh) : nullptr;
  if (!mesh) return {};
  if (item->is_lasso()) return title_of(*item);
  if (item->kind != MarkKind::Boundary)
    return wheel_text(item->is_stroke() ? "%1, radius %2" : "%1 mark, radius %2")
        .arg(title_of(*item), text(length_text(item->radius_mm)));
  return wheel_text("Boundary point, strength %1, reach %2 of vertices; for all boundary points of '%3'")
      .arg(value_of(*mesh, AttractionForce::weight), 0, 'g', 3)
      .arg(counted_text(std::lround(value_of(*mesh, AttractionForce::order)), "ring"))
      .arg(QString::fromStdString(mesh->name));
}

}  // namespace simplexseg
