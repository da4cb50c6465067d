// SPDX-License-Identifier: Apache-2.0
#include "gui/look/theme.h"

#include <QApplication>
#include <QPalette>
#include <QStyleFactory>

namespace simplexseg::theme {

QColor slice_colour(Orientation orientation) {
  switch (orientation) {
    case Orientation::Axial:
      return {232, 96, 84};
    case Orientation::Sagittal:
      return {230, 196, 72};
    case Orientation::Coronal:
      break;
  }
  return {98, 192, 110};
}

void apply(QApplication& application) {
  application.setStyle(QStyleFactory::create("Fusion"));
  QPalette palette;
  const QColor window{37, 40, 45}, base{28, 30, 34}, raised{52, 56, 63}, disabled = kDisabledText;
  palette.setColor(QPalette::Window, window);
  palette.setColor(QPalette::WindowText, kText);
  palette.setColor(QPalette::Base, base);
  palette.setColor(QPalette::AlternateBase, window);
  palette.setColor(QPalette::Text, kText);
  palette.setColor(QPalette::PlaceholderText, disabled);
  palette.setColor(QPalette::Button, raised);
  palette.setColor(QPalette::ButtonText, kText);
  palette.setColor(QPalette::BrightText, Qt::white);
  palette.setColor(QPalette::ToolTipBase, raised);
  palette.setColor(QPalette::ToolTipText, kText);
  palette.setColor(QPalette::Link, kAccent);
  palette.setColor(QPalette::Highlight, QColor(48, 104, 160));
  palette.setColor(QPalette::HighlightedText, Qt::white);
  palette.setColor(QPalette::Light, raised.lighter(120));
  palette.setColor(QPalette::Mid, raised.darker(120));
  palette.setColor(QPalette::Dark, base.darker(120));
  for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText}) {
    palette.setColor(QPalette::Disabled, role, disabled);
  }
  palette.setColor(QPalette::Disabled, QPalette::Highlight, raised);
  application.setPalette(palette);
  application.setStyleSheet(R"(
    QToolTip { color: #dee2e6; background: #343840; border: 1px solid #545a64; padding: 3px; }
    QMainWindow::separator { background: #1c1e22; width: 3px; height: 3px; }
    QDockWidget { font-weight: bold; }
    QDockWidget::title { background: #2e3238; padding: 5px 8px; border-bottom: 1px solid #1c1e22; }
    QDockWidget > QWidget { font-weight: normal; }
    QTabBar::tab { padding: 4px 8px; }
    QMenuBar { background: #25282d; }
    QStatusBar { background: #25282d; border-top: 1px solid #1c1e22; }
    QStatusBar::item { border: none; }
    QScrollArea { border: none; }
    QTreeView { border: 1px solid #1c1e22; border-radius: 3px; }
    QTreeView::item { padding: 2px 0; }
    QHeaderView::section { background: #2e3238; border: none; padding: 3px 6px; color: #969ca4; }
    QToolBar { background: #25282d; border: none; border-bottom: 1px solid #1c1e22; spacing: 2px; padding: 2px 4px; }
    QToolButton { padding: 3px 7px; border: 1px solid transparent; border-radius: 3px; }
    QToolButton:hover { background: #3a3f47; }
    QToolBar QToolButton { font-size: 11px; padding: 2px 5px; }
    QToolButton#run { background: #2b7a4b; color: white; padding: 2px 14px; }
    QToolButton#run:hover { background: #338f58; }
    QToolButton#run:disabled { background: #343840; color: #686e76; }
    QToolButton:checked { background: #30689f; border-color: #408cd6; }
  )");
}

}  // namespace simplexseg::theme
