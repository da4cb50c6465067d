// SPDX-License-Identifier: Apache-2.0
#include "gui/views/point_wheel.h"

#include <QCoreApplication>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "forces/attraction.h"
#include "gui/input/bindings.h"
#include "gui/look/point_look.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr int kOneTurnMs = 1000;  // notches that come sooner are one action
constexpr int kPassingByMs = 600;
constexpr double kBallStep = 1.1;  // a notch
constexpr float kStrengthStep = 1.15f;

const ParameterInfo& info_of(int parameter) { return AttractionForce::parameters[parameter]; }

float value_of(const MeshItem& item, int parameter) {
  return item.parameters.values[static_cast<std::size_t>(ForceId::Attraction)][static_cast<std::size_t>(parameter)];
}

QString tr(const char* text) { return QCoreApplication::translate("PointWheel", text); }

}  // namespace

bool PointWheel::takes(ItemId point) const {
  return point != 0 && !(elsewhere_.isValid() && elsewhere_.elapsed() < kPassingByMs);
}

void PointWheel::turn(ItemId point, const QWheelEvent& event, bool slices) {
  const UserPoint* item = workbench_.scene().find_point(point);
  if (!item) return;
  // Some desktops turn the wheel sideways while Shift is held.
  const QPoint angle = event.angleDelta();
  degrees_ += (angle.y() != 0 ? angle.y() : angle.x()) / 8.0;
  const int notches = static_cast<int>(degrees_ / 15);
  degrees_ -= 15.0 * notches;
  if (notches == 0) return;
  const bool continues = last_ == point && since_.isValid() && since_.elapsed() < kOneTurnMs;
  last_ = point;
  since_.start();
  const std::optional<Act> act = gesture(slices ? Where::Slices : Where::Space, Mouse::WheelOnPoint, event.modifiers());
  if (act == Act::PointReach) change_reach(*item, notches, continues);
  if (act == Act::PointStrength) change_strength(*item, notches, continues);
}

void PointWheel::change_reach(const UserPoint& point, int notches, bool continues) {
  if (point.kind != MarkKind::Boundary) {
    const double least_mm = 0.5 * workbench_.session().volume().geometry().spacing_mm.minCoeff();
    workbench_.apply(
        ResizePoint{point.id, std::clamp(point.radius_mm * std::pow(kBallStep, notches), least_mm, 200.0), continues});
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

QString words_of_point(const Workbench& workbench, ItemId point) {
  const UserPoint* item = workbench.scene().find_point(point);
  const MeshItem* mesh = item ? workbench.scene().find_mesh(item->mesh) : nullptr;
  if (!mesh) return {};
  if (item->kind != MarkKind::Boundary)
    return tr("%1: ball of %2 mm").arg(title_of(item->kind)).arg(item->radius_mm, 0, 'f', 1);
  return tr("Boundary: strength %1, reach %2 rings, for all of \"%3\"")
      .arg(value_of(*mesh, AttractionForce::weight), 0, 'g', 3)
      .arg(value_of(*mesh, AttractionForce::order), 0, 'f', 0)
      .arg(QString::fromStdString(mesh->name));
}

}  // namespace simplexseg
