// SPDX-License-Identifier: Apache-2.0
#include "gui/views/slice_annotations.h"

#include <cmath>

#include "gui/views/slice_view.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {

QString slice_title(const Workbench& workbench, const SliceView& view) {
  const char* names[] = {"x", "y", "z"};
  const VolumeGeometry& geometry = workbench.session().volume().geometry();
  const SliceNumber slice = slice_number(geometry, view.orientation(), view.through_mm());
  const QString title = title_of(view.orientation());
  const WorldBox box = world_box(geometry);
  const int normal = view.axes().normal;
  if (view.slice_mm() < box.low_mm[normal] || view.slice_mm() > box.high_mm[normal])
    return SliceView::tr("%1: outside the image").arg(title);
  const QString number = QString("%1  %2 / %3").arg(title).arg(slice.number).arg(slice.count);
  QString all =
      QString("%1   %2 = %3 mm").arg(number, names[normal]).arg(view.slice_mm(), 0, 'f', position_decimals(geometry));
  // The text must not reach the letter of the patient's side at the middle of the upper edge.
  const auto fits = [&view](const QString& line) {
    constexpr double kBold = 1.15;
    return kBold * view.fontMetrics().horizontalAdvance(line) < view.width() / 2.0 - 16;
  };
  if (fits(all)) return all;
  return fits(number) ? number : QString("%1 %2").arg(title).arg(slice.number);
}

double scale_bar_mm(const SliceView& view) {
  const double most_mm = 0.2 * view.width() * view.mm_per_pixel(), size = std::pow(10, std::floor(std::log10(most_mm)));
  for (const double step : {5.0, 2.0})
    if (step * size <= most_mm) return step * size;
  return size;
}

std::vector<Eigen::Vector3f> scale_bar_lines(const SliceView& view) {
  const double right = view.width() - 10, left = right - scale_bar_mm(view) / view.mm_per_pixel(),
               low = view.height() - 9, high = low - 5;
  std::vector<Eigen::Vector3f> ends;
  ends.reserve(6);
  for (const QPointF& at : {QPointF(left, low), QPointF(right, low), QPointF(left, low), QPointF(left, high),
                            QPointF(right, low), QPointF(right, high)})
    ends.push_back(view.world_of(at).cast<float>());
  return ends;
}

}  // namespace simplexseg
