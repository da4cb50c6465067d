// SPDX-License-Identifier: Apache-2.0
#include "gui/look/point_look.h"

#include <QCoreApplication>
#include <QPainter>
#include <QPixmap>

#include "gui/look/theme.h"

namespace simplexseg {

QString title_of(MarkKind kind) {
  switch (kind) {
    case MarkKind::Inside:
      return QCoreApplication::translate("Points", "Inside");
    case MarkKind::Outside:
      return QCoreApplication::translate("Points", "Outside");
    case MarkKind::Boundary:
      break;
  }
  return QCoreApplication::translate("Points", "Boundary");
}

Glyph glyph_of(MarkKind kind) {
  switch (kind) {
    case MarkKind::Inside:
      return Glyph::Plus;
    case MarkKind::Outside:
      return Glyph::Minus;
    case MarkKind::Boundary:
      break;
  }
  return Glyph::Plain;
}

QColor colour_of(MarkKind kind, const Colour& mesh) {
  switch (kind) {
    case MarkKind::Inside:
      return theme::kInside;
    case MarkKind::Outside:
      return theme::kOutside;
    case MarkKind::Boundary:
      break;
  }
  return {mesh.red, mesh.green, mesh.blue};
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
