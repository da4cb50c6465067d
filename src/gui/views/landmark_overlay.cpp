// SPDX-License-Identifier: Apache-2.0
#include "gui/views/landmark_overlay.h"

#include <QMouseEvent>

#include "gui/look/theme.h"
#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr float kLandmarkRadius = 5;  // logical pixels
}

std::vector<LandmarkOverlay::Point> LandmarkOverlay::points() const {
  const LandmarkInput& input = workbench_.view.landmarks;
  const bool layer = input.next == LandmarkInput::Next::Layer;
  std::vector<Point> points;
  const auto add = [&](const Eigen::Vector3d& at_mm, std::size_t number) {
    const double opacity = handle_opacity(view_.distance_to_slice_mm(at_mm));
    if (opacity > 0) points.push_back({at_mm, number, opacity});
  };
  for (std::size_t n = 0; n < input.pairs.size(); ++n)
    add(layer ? input.pairs[n].shown_mm : input.pairs[n].volume_mm, n + 1);
  return points;
}

void LandmarkOverlay::draw(const Projection& projection) {
  const auto ratio = static_cast<float>(view_.devicePixelRatio());
  std::vector<DiscPainter::Disc> discs;
  for (const Point& point : points())
    discs.push_back({point.at_mm.cast<float>(), rgba_of(theme::kSelected, static_cast<float>(point.opacity)),
                     rgba_of(theme::kSliceBackground, static_cast<float>(point.opacity)), kLandmarkRadius * ratio});
  if (!discs.empty()) discs_.draw(projection, discs);
}

void LandmarkOverlay::add_labels(std::vector<Label>& labels, const QRectF& box) const {
  const LandmarkInput& input = workbench_.view.landmarks;
  for (const Point& point : points()) {
    const QPointF at = view_.pixel_of(point.at_mm);
    labels.push_back({{at.x() + 8, at.y() - 20, 40, 20},
                      Qt::AlignLeft | Qt::AlignTop,
                      QString::number(point.number),
                      theme::kSelected,
                      false});
  }
  if (input.next == LandmarkInput::Next::None) return;
  const QString what = input.next == LandmarkInput::Next::Volume
                           ? SliceView::tr("volume: click landmark %1").arg(input.pairs.size() + 1)
                           : SliceView::tr("layer: click landmark %1").arg(input.pairs.size() + 1);
  labels.push_back({box, Qt::AlignHCenter | Qt::AlignBottom, what, theme::kSelected, true});
}

bool LandmarkOverlay::press(const QMouseEvent& event) {
  LandmarkInput& input = workbench_.view.landmarks;
  if (input.next == LandmarkInput::Next::None || event.button() != Qt::LeftButton ||
      event.modifiers() != Qt::NoModifier || !workbench_.has_volume())
    return false;
  const Eigen::Vector3d at_mm = view_.world_of(event.position());
  if (input.next == LandmarkInput::Next::Volume) {
    if (workbench_.session().volume().geometry().contains(at_mm))
      input.volume_mm = at_mm, input.next = LandmarkInput::Next::Layer;
  } else if (const LayerItem* const layer = workbench_.scene().find_layer(input.layer)) {
    const Eigen::Vector3d layer_mm = workbench_.layer_images().transform_of(*layer)(at_mm);
    const std::shared_ptr<const Volume> image = workbench_.layer_images().image_of(*layer);
    if (image && layer_mm.allFinite() && image->geometry().contains(layer_mm)) {
      input.pairs.push_back({input.volume_mm, layer_mm, at_mm});
      input.next = LandmarkInput::Next::Volume;
    }
  }
  workbench_.view_edited();
  return true;
}

}  // namespace simplexseg
