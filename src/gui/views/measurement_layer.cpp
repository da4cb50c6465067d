// SPDX-License-Identifier: Apache-2.0
#include "gui/views/measurement_layer.h"

#include <QFontMetricsF>
#include <QPolygonF>
#include <algorithm>
#include <span>

#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/views/measurement_shape.h"
#include "gui/views/slice_hits.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

/// Positions of handles in pixels.
std::vector<QPointF> pixels_of(const SliceView& view, std::span<const Eigen::Vector3d> positions_mm) {
  std::vector<QPointF> pixels;
  for (const Eigen::Vector3d& position : positions_mm) pixels.push_back(view.pixel_of(position));
  return pixels;
}

QRectF box_around(const std::vector<QPointF>& pixels) {
  const QRectF box = QPolygonF(QList<QPointF>(pixels.begin(), pixels.end())).boundingRect();
  constexpr double kLine = 3;
  return box.adjusted(-kLine, -kLine, kLine, kLine);
}

/// Size of a text of the view, logical pixels.
QSizeF label_size(const SliceView& view, const QString& text) {
  QFont font = view.font();
  font.setBold(true);
  return QFontMetricsF(font).size(0, text) + QSizeF(2, 2);
}

constexpr double kGap = 10, kMargin = 6;  // from the shape to its text, and from the text to the edge, logical pixels

/// Places for a text of a size beside a shape, the best one first: right, left, below and above of its handles.
std::vector<QRectF> places_beside(const std::vector<QPointF>& handles, const QSizeF& size) {
  const auto by_x = [](const QPointF& a, const QPointF& b) { return a.x() < b.x(); };
  const auto by_y = [](const QPointF& a, const QPointF& b) { return a.y() < b.y(); };
  const QPointF right = *std::ranges::max_element(handles, by_x), left = *std::ranges::min_element(handles, by_x);
  const QPointF low = *std::ranges::max_element(handles, by_y), high = *std::ranges::min_element(handles, by_y);
  const double w = size.width(), h = size.height(), middle = (left.x() + right.x()) / 2;
  return {QRectF(QPointF(right.x() + kGap, right.y() - h / 2), size),
          QRectF(QPointF(left.x() - kGap - w, left.y() - h / 2), size),
          QRectF(QPointF(middle - w / 2, low.y() + kGap), size),
          QRectF(QPointF(middle - w / 2, high.y() - kGap - h), size)};
}

/// Place for a text at the vertex of an angle, outside its legs.
QRectF place_at_vertex(const std::vector<QPointF>& handles, const QSizeF& size) {
  const auto unit = [&](const QPointF& end) {
    return (end - handles[1]) / std::max(pixel_length(end - handles[1]), 1e-9);
  };
  QPointF inwards = unit(handles[0]) + unit(handles[2]);
  if (pixel_length(inwards) < 1e-3) inwards = QPointF(-unit(handles[0]).y(), unit(handles[0]).x());
  inwards /= pixel_length(inwards);
  const QPointF centre =
      handles[1] - QPointF(inwards.x() * (kGap + size.width() / 2), inwards.y() * (kGap + size.height() / 2));
  return QRectF(centre - QPointF(size.width(), size.height()) / 2, size);
}

}  // namespace

void MeasurementLayer::draw(const Projection& projection, const Workbench& workbench, const SliceView& view,
                            const std::optional<Measurement>& draft) {
  labels_.clear();
  if (const void* voxels = workbench.session().volume().data(); voxels != voxels_) values_.clear(), voxels_ = voxels;
  std::erase_if(values_, [&](const auto& one) { return one.first && !workbench.scene().find_measurement(one.first); });
  shapes_.clear();
  for (const Measurement& measurement : workbench.scene().measurements)
    if (lies_in_slice(workbench, view, measurement.points_mm))
      shapes_.emplace_back(measurement.id, box_around(pixels_of(view, handles_of(measurement))));
  draw_axes(projection, workbench, view);
  for (const Measurement& measurement : workbench.scene().measurements)
    if (lies_in_slice(workbench, view, measurement.points_mm))
      draw_measurement(projection, workbench, view, measurement);
  if (draft && !defect_of(draft->kind, draft->points_mm)) draw_measurement(projection, workbench, view, *draft);
}

void MeasurementLayer::draw_lines(const Projection& projection, const SliceView& view,
                                  const std::vector<Eigen::Vector3f>& ends, const QColor& colour, float width) {
  const auto ratio = static_cast<float>(view.devicePixelRatio());
  lines_.draw(projection, ends, rgba_of(theme::kSliceBackground, 0.7f), (width + 2) * ratio);
  lines_.draw(projection, ends, rgba_of(colour), width * ratio);
}

const MeasurementValues& MeasurementLayer::values_of_cached(const Workbench& workbench,
                                                            const Measurement& measurement) {
  const auto [at, fresh] = values_.try_emplace(measurement.id);
  if (fresh || at->second.first != measurement)
    at->second = {measurement, values_of(measurement, workbench.session().volume())};
  return at->second.second;
}

void MeasurementLayer::draw_measurement(const Projection& projection, const Workbench& workbench, const SliceView& view,
                                        const Measurement& measurement) {
  const ViewState& state = workbench.view;
  const bool hovered = measurement.id != 0 && measurement.id == state.hovered_measurement,
             selected = measurement.id != 0 && measurement.id == state.selected_measurement();
  const QColor& colour = selected ? theme::kSelected : theme::kMeasurement;
  draw_lines(projection, view, lines_of(measurement), colour, hovered ? 2.6f : 1.6f);
  const auto ratio = static_cast<float>(view.devicePixelRatio());
  std::vector<DiscPainter::Disc> discs;
  for (const Eigen::Vector3d& handle : handles_of(measurement))
    discs.push_back({handle.cast<float>(), rgba_of(theme::kSliceBackground, 0.6f), rgba_of(colour),
                     (hovered || selected ? 4.5f : 3.2f) * ratio});
  discs_.draw(projection, discs);

  QStringList lines;
  if (hovered || selected) lines << QString::fromStdString(measurement.name);
  for (const std::string& line : lines_of(values_of_cached(workbench, measurement), workbench.intensity_unit()))
    lines << QString::fromStdString(line);
  const std::vector<QPointF> handles = pixels_of(view, handles_of(measurement));
  const QString text = lines.join('\n');
  const QSizeF size = label_size(view, text);
  std::vector<QRectF> places = places_beside(handles, size);
  if (measurement.kind == MeasurementKind::Angle) places.insert(places.begin(), place_at_vertex(handles, size));
  place_label(view, measurement.id, places, text, colour);
}

void MeasurementLayer::draw_axes(const Projection& projection, const Workbench& workbench, const SliceView& view) {
  const ViewState& state = workbench.view;
  constexpr int kAxialNormal = 2;
  if (!state.show_axes || !state.show_meshes || !state.object_axes || view.axes().normal != kAxialNormal) return;
  for (const auto& [mesh, axes] : *state.object_axes) {
    const MeshItem* const item = workbench.scene().find_mesh(mesh);
    const Eigen::Vector3d middle = (axes.long_ends_mm[0] + axes.long_ends_mm[1]) / 2;
    if (!item || !item->visible || !lies_in_slice(workbench, view, {middle})) continue;
    std::vector<Eigen::Vector3f> ends;
    for (const auto& axis : {axes.long_ends_mm, axes.short_ends_mm})
      for (const Eigen::Vector3d& end : axis) ends.push_back(end.cast<float>());
    const QColor colour(item->colour.red, item->colour.green, item->colour.blue);
    draw_lines(projection, view, ends, colour, 1.6f);
    const QString label =
        QString("%1 \u00d7 %2")
            .arg(text(measured_length_text(axes.long_mm())), text(measured_length_text(axes.short_mm())));
    place_label(view, mesh, places_beside(pixels_of(view, axes.long_ends_mm), label_size(view, label)), label, colour);
  }
}

void MeasurementLayer::place_label(const SliceView& view, ItemId item, const std::vector<QRectF>& places,
                                   const QString& text, const QColor& colour) {
  const QRectF inner = QRectF(view.rect()).adjusted(kMargin, kMargin, -kMargin, -kMargin);
  const auto is_readable = [&](const QRectF& place) {
    return inner.contains(place) &&
           std::ranges::none_of(labels_, [&](const Label& other) { return other.box.intersects(place); });
  };
  const auto is_free = [&](const QRectF& place) {
    return is_readable(place) && std::ranges::none_of(shapes_, [&](const auto& other) {
             return other.first != item && other.second.intersects(place);
           });
  };
  auto found = std::ranges::find_if(places, is_free);
  if (found == places.end()) found = std::ranges::find_if(places, is_readable);
  QRectF box = found != places.end() ? *found : places.front();
  box.moveLeft(std::clamp(box.left(), inner.left(), std::max(inner.left(), inner.right() - box.width())));
  box.moveTop(std::clamp(box.top(), inner.top(), std::max(inner.top(), inner.bottom() - box.height())));
  labels_.push_back({box, Qt::AlignLeft | Qt::AlignTop, text, colour});
}

}  // namespace simplexseg
