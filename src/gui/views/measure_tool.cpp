// SPDX-License-Identifier: Apache-2.0
#include "gui/views/measure_tool.h"

#include <QInputDialog>
#include <QMenu>
#include <utility>

#include "gui/views/slice_hits.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr double kLeastPixels = 4;  // shortest ruler or leg, and shortest side of an ellipse, logical pixels

MeasurementKind kind_of_tool(Tool tool) {
  return tool == Tool::Ruler   ? MeasurementKind::Ruler
         : tool == Tool::Angle ? MeasurementKind::Angle
                               : MeasurementKind::Ellipse;
}

QString instruction(Tool tool) {
  switch (tool) {
    case Tool::Ruler:
      return SliceView::tr("Ruler: drag from one end to the other");
    case Tool::Ellipse:
      return SliceView::tr("Ellipse: drag from one corner to the opposite one");
    default:
      return SliceView::tr("Angle: click the end of a leg, the vertex, and the end of the other leg");
  }
}

}  // namespace

bool MeasureTool::is_current() const {
  return draft_ && draft_->tool == workbench_.view.tool && draft_->slice_mm == view_.slice_mm();
}

bool MeasureTool::grabs_at(const QPointF& pixel) const {
  const Tool tool = workbench_.view.tool;
  return (measures(tool) || tool == Tool::Crosshair) && !is_current() &&
         measurement_in_slice(workbench_, view_, pixel).has_value();
}

void MeasureTool::discard_outdated() {
  if (draft_ && !is_current()) draft_.reset();
}

bool MeasureTool::press(const QPointF& pixel) {
  discard_outdated();
  const Eigen::Vector3d at_mm = view_.world_of(pixel);
  if (draft_) {  // a further click of an angle
    if (pixel_length(pixel - view_.pixel_of(draft_->points_mm.back())) < kLeastPixels) return true;
    draft_->points_mm.push_back(at_mm), draft_->mouse_mm = at_mm;
    if (draft_->points_mm.size() == point_count(MeasurementKind::Angle)) finish();
    view_.update();
    return true;
  }
  if (grabs_at(pixel)) {
    const MeasurementHit hit = *measurement_in_slice(workbench_, view_, pixel);
    const Measurement& measurement = *workbench_.scene().find_measurement(hit.measurement);
    grab_ = Grab{hit, handles_of(measurement)[hit.handle.value_or(0)] - at_mm};
    workbench_.view.last_measurement = hit.measurement, workbench_.view.selected_point = 0;
    workbench_.view_edited();
    return true;
  }
  const Tool tool = workbench_.view.tool;
  if (!measures(tool)) return false;
  draft_ = Draft{tool, view_.slice_mm(), {at_mm}, at_mm};
  view_.update();
  return true;
}

void MeasureTool::move(const QPointF& pixel, bool dragged) {
  if (grab_) {
    if (dragged || grab_->continues) drag_to(pixel);
  } else if (draft_) {
    discard_outdated();
    if (draft_) draft_->mouse_mm = view_.world_of(pixel);
    view_.update();
  }
}

void MeasureTool::drag_to(const QPointF& pixel) {
  const Measurement* const measurement = workbench_.scene().find_measurement(grab_->hit.measurement);
  if (!measurement) return;
  const Eigen::Vector3d to_mm = view_.world_of(pixel) + grab_->offset_mm;
  std::vector<Eigen::Vector3d> points = measurement->points_mm;
  if (grab_->hit.handle)
    points = with_moved_handle(*measurement, *grab_->hit.handle, to_mm);
  else
    for (Eigen::Vector3d& point : points) point += to_mm - measurement->points_mm[0];
  // For example both ends of a ruler at one position.
  if (points == measurement->points_mm || defect_of(measurement->kind, points)) return;
  if (workbench_.apply(MoveMeasurement{measurement->id, points, grab_->continues})) grab_->continues = true;
}

void MeasureTool::release(const QPointF& pixel, bool dragged) {
  if (std::exchange(grab_, std::nullopt)) return;
  if (!draft_) return;
  draft_->mouse_mm = view_.world_of(pixel);
  if (draft_->tool != Tool::Angle)
    finish();
  else if (dragged && draft_->points_mm.size() == 1)
    draft_->points_mm.push_back(draft_->mouse_mm);
  view_.update();
}

void MeasureTool::finish() {
  const std::optional<Measurement> drawn = draft();
  const Tool tool = draft_->tool;
  const QPointF size = view_.pixel_of(draft_->mouse_mm) - view_.pixel_of(draft_->points_mm[0]);
  draft_.reset();
  const bool too_small = tool == Tool::Ruler     ? pixel_length(size) < kLeastPixels
                         : tool == Tool::Ellipse ? std::min(std::abs(size.x()), std::abs(size.y())) < kLeastPixels
                                                 : false;
  if (!drawn || too_small)
    workbench_.notify(Severity::Note, instruction(tool));
  else
    workbench_.apply(AddMeasurement{drawn->kind, drawn->points_mm, {}});
}

bool MeasureTool::cancel() {
  if (!std::exchange(draft_, std::nullopt)) return false;
  view_.update();
  return true;
}

std::optional<Measurement> MeasureTool::draft() const {
  if (!is_current()) return std::nullopt;
  Measurement measurement{0, kind_of_tool(draft_->tool), draft_->points_mm, {}};
  std::vector<Eigen::Vector3d>& points = measurement.points_mm;
  if (measurement.kind == MeasurementKind::Ellipse) {
    const SliceAxes axes = view_.axes();
    points = ellipse_in_rectangle(points[0], draft_->mouse_mm, axes.right, axes.up);
  } else if (points.size() < point_count(measurement.kind)) {
    points.push_back(draft_->mouse_mm);
  }
  if (points.size() == 2) measurement.kind = MeasurementKind::Ruler;  // the first leg of an angle
  return measurement;
}

void MeasureTool::hover(const std::optional<QPointF>& pixel) {
  if (grab_) return;
  const ItemId under =
      pixel && grabs_at(*pixel) ? measurement_in_slice(workbench_, view_, *pixel)->measurement : ItemId{0};
  if (std::exchange(workbench_.view.hovered_measurement, under) != under) workbench_.view_edited();
}

void MeasureTool::rename(ItemId measurement) {
  const Measurement* const item = workbench_.scene().find_measurement(measurement);
  if (!item) return;
  bool accepted = false;
  const QString name = QInputDialog::getText(&view_, SliceView::tr("Rename the measurement"), SliceView::tr("Name:"),
                                             QLineEdit::Normal, QString::fromStdString(item->name), &accepted);
  if (accepted && !name.isEmpty()) workbench_.apply(RenameMeasurement{measurement, name.toStdString()});
}

void MeasureTool::add_entries(QMenu& menu, const QPointF& pixel) {
  const std::optional<MeasurementHit> hit = measurement_in_slice(workbench_, view_, pixel);
  if (!hit) return;
  const ItemId id = hit->measurement;
  menu.addAction(SliceView::tr("Delete this measurement"), [=, this] { workbench_.apply(DeleteMeasurement{id}); });
  menu.addAction(SliceView::tr("Rename this measurement..."), [=, this] { rename(id); });
  menu.addSeparator();
}

}  // namespace simplexseg
