// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "gui/drawing/label_painter.h"
#include "image/measurement.h"
#include "session/scene.h"

namespace simplexseg {

class SliceView;
class Workbench;

/// Draws the measurements that lie in a slice, and the long and short axes of the meshes, with their values.
class MeasurementLayer {
 public:
  void create() { lines_.create(), discs_.create(); }
  void destroy() { lines_.destroy(), discs_.destroy(); }
  /// `draft`: measurement that is being drawn, or none; it can have a defect.
  void draw(const Projection& projection, const Workbench& workbench, const SliceView& view,
            const std::optional<Measurement>& draft);
  /// Adds the values of what was drawn last.
  void add_labels(std::vector<Label>& labels) const { labels.insert(labels.end(), labels_.begin(), labels_.end()); }

 private:
  /// Draws segments with a dark edge for bright images. `width`: logical pixels.
  void draw_lines(const Projection& projection, const SliceView& view, const std::vector<Eigen::Vector3f>& ends,
                  const QColor& colour, float width);
  void draw_measurement(const Projection& projection, const Workbench& workbench, const SliceView& view,
                        const Measurement& measurement);
  void draw_axes(const Projection& projection, const Workbench& workbench, const SliceView& view);
  /// Adds a text of an item at the first of several places that is within the view and free of other texts and items;
  /// else free of texts; else at the first.
  void place_label(const SliceView& view, ItemId item, const std::vector<QRectF>& places, const QString& text,
                   const QColor& colour);
  const MeasurementValues& values_of_cached(const Workbench& workbench, const Measurement& measurement);

  LinePainter lines_;
  DiscPainter discs_;
  std::vector<Label> labels_;
  std::vector<std::pair<ItemId, QRectF>> shapes_;  ///< boxes around the measurements in the slice, logical pixels
  const void* voxels_ = nullptr;                   ///< voxels from which `values_` was computed
  std::map<ItemId, std::pair<Measurement, MeasurementValues>> values_;
};

}  // namespace simplexseg
