// SPDX-License-Identifier: Apache-2.0
#include "gui/look/symbols.h"

#include <QIconEngine>
#include <QPainter>
#include <QPainterPath>
#include <QPixmap>
#include <algorithm>

#include "gui/look/theme.h"

namespace simplexseg {
namespace {

constexpr int kSide = 20;  // side of the icon; all coordinates below have this scale

void arrow_back(QPainter& painter) {
  QPainterPath path(QPointF(5, 8));
  path.lineTo(12, 8);
  path.arcTo(QRectF(8, 8, 8, 8), 90, -180);
  path.lineTo(7, 16);
  painter.drawPath(path);
  painter.drawPolyline(QPolygonF({{8.5, 4.5}, {5, 8}, {8.5, 11.5}}));
}

void marked_point(QPainter& painter, const QColor& colour, bool across, bool down) {
  painter.save();
  painter.setBrush(colour);
  painter.drawEllipse(QRectF(3.5, 3.5, 13, 13));
  painter.restore();
  if (across) painter.drawLine(QPointF(7, 10), QPointF(13, 10));
  if (down) painter.drawLine(QPointF(10, 7), QPointF(10, 13));
}

void brush(QPainter& painter) {
  painter.drawLine(QPointF(16.5, 3.5), QPointF(9.5, 10.5));
  painter.save();
  painter.setBrush(theme::kInside);
  QPainterPath tip(QPointF(9.5, 10.5));
  tip.cubicTo(5.5, 10, 6.5, 15, 3, 16.5);
  tip.cubicTo(8, 18, 11.5, 15, 9.5, 10.5);
  painter.drawPath(tip);
  painter.restore();
}

void eraser(QPainter& painter) {
  painter.save();
  painter.setBrush(theme::kOutside);
  painter.drawPolygon(QPolygonF({{3.5, 12.5}, {8, 8}, {13, 13}, {9.5, 16.5}, {7.5, 16.5}}));
  painter.restore();
  painter.drawPolygon(QPolygonF({{8, 8}, {12.5, 3.5}, {17.5, 8.5}, {13, 13}}));
}

void snowflake(QPainter& painter) {
  for (int arm = 0; arm < 6; ++arm) {
    painter.save();
    painter.translate(10, 10);
    painter.rotate(60 * arm);
    painter.drawLine(QPointF(0, 0), QPointF(0, -8));
    painter.drawPolyline(QPolygonF({{-2.2, -7}, {0, -4.8}, {2.2, -7}}));
    painter.restore();
  }
}

void padlock(QPainter& painter, bool closed) {
  if (closed) painter.setBrush(painter.pen().color());
  painter.drawRoundedRect(QRectF(4.5, 9, 11, 8), 1.5, 1.5);
  painter.setBrush(Qt::NoBrush);
  QPainterPath bow(QPointF(7, 9));
  bow.lineTo(7, 6.5);
  bow.arcTo(QRectF(7, 3, 6, 7), 180, -180);
  bow.lineTo(13, closed ? 9.0 : 7.0);
  painter.drawPath(bow);
}

void eye(QPainter& painter) {
  QPainterPath path(QPointF(2, 10));
  path.quadTo(10, 1.5, 18, 10);
  path.quadTo(10, 18.5, 2, 10);
  painter.drawPath(path);
  painter.drawEllipse(QPointF(10, 10), 2.4, 2.4);
}

void filled(QPainter& painter, const QPolygonF& shape) {
  painter.save();
  painter.setBrush(painter.pen().color());
  painter.drawPolygon(shape);
  painter.restore();
}

void draw(QPainter& painter, Symbol symbol) {
  switch (symbol) {
    case Symbol::Open:
      painter.drawPolyline(QPolygonF({{12, 3}, {5, 3}, {5, 17}, {15, 17}, {15, 6}, {12, 3}, {12, 6}, {15, 6}}));
      return;
    case Symbol::Folder:
      painter.drawPolygon(QPolygonF({{3, 5}, {8, 5}, {10, 7.5}, {17, 7.5}, {17, 16}, {3, 16}}));
      return;
    case Symbol::Crosshair:
      for (const QPointF& direction : {QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)})
        painter.drawLine(QPointF(10, 10) + 2.5 * direction, QPointF(10, 10) + 8 * direction);
      return;
    case Symbol::ZoomPan:
      painter.drawEllipse(QRectF(3, 3, 10, 10));
      painter.drawLine(QPointF(11.8, 11.8), QPointF(17, 17));
      return;
    case Symbol::Seed:
      painter.drawEllipse(QRectF(3, 3, 14, 14));
      painter.drawLine(QPointF(10, 10), QPointF(17, 10));
      filled(painter, QPolygonF({{9, 9}, {11, 9}, {11, 11}, {9, 11}}));
      return;
    case Symbol::Box:
      painter.drawRect(QRectF(3.5, 5, 13, 10));
      return;
    case Symbol::Boundary: {
      QPainterPath outline(QPointF(2, 15));
      outline.cubicTo(6, 3, 14, 17, 18, 5);
      painter.drawPath(outline);
      painter.setBrush(painter.pen().color());
      painter.drawEllipse(QPointF(10, 10), 3, 3);
      return;
    }
    case Symbol::Inside:
      marked_point(painter, theme::kInside, true, true);
      return;
    case Symbol::Outside:
      marked_point(painter, theme::kOutside, true, false);
      return;
    case Symbol::Brush:
      brush(painter);
      return;
    case Symbol::Eraser:
      eraser(painter);
      return;
    case Symbol::Freeze:
      snowflake(painter);
      return;
    case Symbol::Ruler:
      painter.drawPolygon(QPolygonF({{2.5, 13.5}, {13.5, 2.5}, {17.5, 6.5}, {6.5, 17.5}}));
      for (const double at : {2.75, 5.5, 8.25})
        painter.drawLine(QPointF(2.5 + at, 13.5 - at), QPointF(4.3 + at, 15.3 - at));
      return;
    case Symbol::Angle:
      painter.drawPolyline(QPolygonF({{15.5, 3.5}, {3, 16}, {17.5, 16}}));
      painter.drawArc(QRectF(-5, 8, 16, 16), 0, 45 * 16);
      return;
    case Symbol::Ellipse:
      painter.translate(10, 10);
      painter.rotate(-35);
      painter.drawEllipse(QRectF(-8, -5, 16, 10));
      for (const double end : {-8.0, 8.0})
        filled(painter, QPolygonF({{end - 1, -1}, {end + 1, -1}, {end + 1, 1}, {end - 1, 1}}));
      return;
    case Symbol::Run:
      filled(painter, QPolygonF({{6, 4}, {16, 10}, {6, 16}}));
      return;
    case Symbol::Pause:
      filled(painter, QPolygonF({{5.5, 4}, {8, 4}, {8, 16}, {5.5, 16}}));
      filled(painter, QPolygonF({{12, 4}, {14.5, 4}, {14.5, 16}, {12, 16}}));
      return;
    case Symbol::Step:
      filled(painter, QPolygonF({{4, 4}, {12, 10}, {4, 16}}));
      painter.drawLine(QPointF(15, 4), QPointF(15, 16));
      return;
    case Symbol::Reset:
      painter.drawArc(QRectF(4, 4, 12, 12), 60 * 16, 290 * 16);
      painter.drawPolyline(QPolygonF({{13, 1.8}, {13.2, 5}, {10, 5.8}}));
      return;
    case Symbol::Undo:
      arrow_back(painter);
      return;
    case Symbol::Redo:
      painter.translate(kSide, 0);
      painter.scale(-1, 1);
      arrow_back(painter);
      return;
    case Symbol::WindowLevel: {
      painter.drawEllipse(QRectF(3, 3, 14, 14));
      painter.setBrush(painter.pen().color());
      painter.drawPie(QRectF(3, 3, 14, 14), 90 * 16, 180 * 16);
      return;
    }
    case Symbol::AutoContrast:
      painter.drawPolyline(QPolygonF({{3, 3}, {3, 17}, {17, 17}}));
      painter.drawPolyline(QPolygonF({{5, 15}, {8, 13}, {10, 6}, {12, 5}, {14, 13}, {17, 15}}));
      return;
    case Symbol::Fit:
      for (const auto& [x, y] : {std::pair{1, 1}, {-1, 1}, {1, -1}, {-1, -1}})
        painter.drawPolyline(
            QPolygonF({{10.0 + 7 * x, 10.0 + 3 * y}, {10.0 + 7 * x, 10.0 + 7 * y}, {10.0 + 3 * x, 10.0 + 7 * y}}));
      return;
    case Symbol::Shown:
      eye(painter);
      return;
    case Symbol::Hidden:
      eye(painter);
      painter.drawLine(QPointF(4, 17), QPointF(16, 3));
      return;
    case Symbol::Locked:
      padlock(painter, true);
      return;
    case Symbol::Unlocked:
      padlock(painter, false);
      return;
    case Symbol::Menu:
      painter.setBrush(painter.pen().color());
      for (const double y : {4.5, 10.0, 15.5}) painter.drawEllipse(QPointF(10, y), 0.8, 0.8);
      return;
  }
}

class SymbolEngine : public QIconEngine {
 public:
  SymbolEngine(Symbol symbol, const QColor& colour) : symbol_(symbol), colour_(colour) {}
  void paint(QPainter* painter, const QRect& rect, QIcon::Mode mode, QIcon::State) override {
    const QColor text = colour_.isValid() ? colour_ : theme::shades().text;
    painter->save();
    painter->setRenderHint(QPainter::Antialiasing);
    const double side = std::min(rect.width(), rect.height());
    painter->translate(QRectF(rect).center() - QPointF(side, side) / 2);
    painter->scale(side / kSide, side / kSide);
    painter->setBrush(Qt::NoBrush);
    painter->setPen(QPen(mode == QIcon::Disabled ? theme::shades().disabled : text, 1.5, Qt::SolidLine, Qt::RoundCap,
                         Qt::RoundJoin));
    draw(*painter, symbol_);
    painter->restore();
  }
  QPixmap pixmap(const QSize& size, QIcon::Mode mode, QIcon::State state) override {
    QPixmap pixmap(size);
    pixmap.fill(Qt::transparent);
    QPainter painter(&pixmap);
    paint(&painter, QRect(QPoint(), size), mode, state);
    return pixmap;
  }
  QIconEngine* clone() const override { return new SymbolEngine(*this); }

 private:
  Symbol symbol_;
  QColor colour_;
};

}  // namespace

QIcon icon_of(Symbol symbol, const QColor& colour) { return QIcon(new SymbolEngine(symbol, colour)); }

}  // namespace simplexseg
