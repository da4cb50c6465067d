// SPDX-License-Identifier: Apache-2.0
#include "gui/look/point_style.h"

#include <QCoreApplication>
#include <QPainter>
#include <QPixmap>
#include <optional>

#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "session/lasso.h"

namespace simplexseg {

namespace {

struct PointStyle {
  const char* title;
  Glyph glyph;
  std::optional<QColor> colour;  ///< none: the mesh's colour
};

const PointStyle& style_of(MarkKind kind) {
  static const PointStyle styles[] = {{QT_TRANSLATE_NOOP("Points", "Inside"), Glyph::Plus, theme::kInside},
                                      {QT_TRANSLATE_NOOP("Points", "Outside"), Glyph::Minus, theme::kOutside},
                                      {QT_TRANSLATE_NOOP("Points", "Boundary"), Glyph::Plain, std::nullopt}};
  return styles[static_cast<int>(kind)];
}

}  // namespace

QString title_of(MarkKind kind) { return QCoreApplication::translate("Points", style_of(kind).title); }
QString title_of(const UserPoint& point) {
  if (point.edit != VoxelEdit::None) return title_of(point.edit);
  if (point.is_paint())
    return point.kind == MarkKind::Inside ? QCoreApplication::translate("Points", "Paint")
                                          : QCoreApplication::translate("Points", "Eraser");
  const QString kind = title_of(point.kind);
  if (point.is_lasso())
    return QCoreApplication::translate("Points", "Lasso, %1, %2")
        .arg(kind.toLower(), counted_text(stroke_count(point), "stroke"));
  return point.is_stroke() ? QCoreApplication::translate("Points", "%1 stroke").arg(kind) : kind;
}
QString title_of(VoxelEdit edit) {
  QString title = QCoreApplication::translate("Edits", info_of(edit).title);
  title[0] = title[0].toUpper();
  return title;
}
Glyph glyph_of(MarkKind kind) { return style_of(kind).glyph; }
QColor colour_of(MarkKind kind, const Colour& mesh) {
  return style_of(kind).colour.value_or(QColor(mesh.red, mesh.green, mesh.blue));
}
bool is_locked(const Scene& scene, ItemId point) {
  const UserPoint* const one = scene.find_point(point);
  const MeshItem* const item = one ? scene.find_mesh(one->mesh) : nullptr;
  return item && item->locked;
}

QIcon handle_icon(MarkKind kind, const Colour& mesh) {
  QPixmap pixmap(28, 28);
  pixmap.fill(Qt::transparent);
  pixmap.setDevicePixelRatio(2);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  const Glyph glyph = glyph_of(kind);
  painter.setBrush(colour_of(kind, mesh));
  painter.setPen(QPen(Qt::white, glyph == Glyph::Plain ? 2 : 1));
  painter.drawEllipse(QRectF(1.5, 1.5, 11, 11));
  painter.setPen(QPen(Qt::white, 2));
  if (glyph != Glyph::Plain) painter.drawLine(QPointF(4.5, 7), QPointF(9.5, 7));
  if (glyph == Glyph::Plus) painter.drawLine(QPointF(7, 4.5), QPointF(7, 9.5));
  return QIcon(pixmap);
}

}  // namespace simplexseg
