// SPDX-License-Identifier: Apache-2.0
#include "gui/look/theme.h"

#include <QApplication>
#include <QDBusConnection>
#include <QDBusMessage>
#include <QDBusVariant>
#include <QFileInfo>
#include <QFontMetrics>
#include <QPalette>
#include <QStyleFactory>
#include <algorithm>
#include <cmath>
#include <utility>

namespace simplexseg::theme {
namespace {

const Shades kDark{
    .window{37, 40, 45},
    .base{28, 30, 34},
    .raised{52, 56, 63},
    .hover{63, 69, 78},
    .checked{42, 96, 150},
    .header{46, 50, 56},
    .line{20, 22, 25},
    .card{42, 45, 51},
    .active_card{43, 59, 77},
    .text = kText,
    .dim{159, 165, 173},
    .disabled{112, 118, 126},
    .accent = kAccent,
    .warning{240, 173, 78},
};
const Shades kLight{
    .window{240, 241, 243},
    .base{255, 255, 255},
    .raised{226, 229, 233},
    .hover{212, 217, 223},
    .checked{200, 222, 243},
    .header{230, 232, 236},
    .line{196, 201, 207},
    .card{250, 251, 252},
    .active_card{221, 234, 248},
    .text{29, 33, 38},
    .dim{86, 93, 102},
    .disabled{146, 152, 160},
    .accent{28, 104, 176},
    .warning{140, 78, 0},
};

bool dark = true;
double usual_points = 0;  ///< text size of the desktop, points; 0 before apply()

/// Style rules, with placeholders for colours and text sizes in angle brackets.
constexpr const char* kRules = R"(
  QToolTip { color: <text>; background: <raised>; border: 1px solid <line>; padding: 3px; }
  QMainWindow::separator { background: <line>; width: 3px; height: 3px; }
  QTabBar::tab { padding: 4px 8px; }
  QMenuBar { background: <window>; }
  QStatusBar { background: <window>; border-top: 1px solid <line>; }
  QStatusBar::item { border: none; }
  QScrollArea { border: none; }
  QTreeView, QListWidget { border: 1px solid <line>; border-radius: 3px; }
  QTreeView::item, QListWidget::item { padding: 2px 0; }
  QTableCornerButton::section { background: <header>; border: none; }
  QHeaderView::section { background: <header>; border: none; padding: 3px 6px; color: <dim>; }
  QToolBar { background: <window>; border: none; border-bottom: 1px solid <line>; spacing: 2px; padding: 2px 4px; }
  QToolButton { padding: 3px 7px; border: 1px solid transparent; border-radius: 3px; }
  QToolButton:hover { background: <hover>; }
  QToolButton:checked { background: <checked>; border-color: <accent>; }
  QToolButton:focus, QSlider:focus, QCheckBox:focus, QComboBox:focus { border: 1px solid <accent>; }
  QToolBar QToolButton { font-size: <small>; padding: 2px 5px; }
  QToolBar QToolButton#qt_toolbar_ext_button { background: <raised>; padding: 0; margin: 3px 0; }
  QToolBar QToolButton#qt_toolbar_ext_button:hover { background: <hover>; }
  QToolButton#run { background: #2b7a4b; color: white; padding: 2px 14px; }
  QToolButton#run:hover { background: #338f58; }
  QToolButton#run:disabled { background: <raised>; color: <disabled>; }
  QCheckBox::indicator:unchecked, QTreeView::indicator {
    width: 11px; height: 11px; border: 1px solid <dim>; border-radius: 2px; background: <base>;
  }
  QTreeView::indicator:checked { background: <accent>; }
  QCheckBox::indicator:unchecked:disabled { border-color: <disabled>; }
  QLabel[role="dim"] { color: <dim>; }
  QLabel[role="small"] { color: <dim>; font-size: <small>; }
  QLabel[role="warning"] { color: <warning>; }
  QToolButton[role="flat"] { padding: 1px; }
  QToolButton[role="flat"]:checked { background: transparent; border-color: transparent; }
  QToolButton[role="flat"]:focus { border-color: <accent>; }
  QToolButton[role="flat"]::menu-indicator { image: none; }
  QToolButton[role="raised"] { background: <raised>; }
  QToolButton[role="raised"]:hover { background: <hover>; }
  QToolButton[role="raised"]:checked { background: <checked>; }
  QLineEdit[role="title"] { background: transparent; font-weight: bold; }
  QLineEdit[role="title"]:focus { background: <base>; font-weight: normal; }
  QSpinBox[role="title"] { background: transparent; }
  QSpinBox[role="title"]:focus { background: <base>; }
  #mesh_card { background: <card>; border: 1px solid <line>; border-radius: 4px; }
  #mesh_card[active="true"] { background: <active_card>; border-color: <accent>; }
  QFrame#gap { background: <accent>; }
  #message_bar QLabel, #message_bar QToolButton { color: white; }
  #step_strip { background: <header>; }
  #step_strip QToolButton { color: <dim>; padding: 2px 10px; border-radius: 9px; }
  #step_strip QToolButton:checked { color: <text>; background: <checked>; }
  #start_page { background: <window>; }
  #start_page QLabel#title { font-size: <large>; }
  #start_page QPushButton { text-align: left; padding: 5px 8px; border: 1px solid transparent; border-radius: 3px; }
  #start_page QPushButton:hover, #start_page QPushButton:focus { background: <hover>; }
  #start_page QPushButton:focus { border-color: <accent>; }
  #start_page QToolButton#entry { background: <raised>; padding: 10px 14px; }
  #start_page QToolButton#entry:hover, #start_page QToolButton#entry:focus { background: <hover>; }
  #start_page QToolButton#first_entry { background: #30689f; color: white; padding: 10px 14px; }
  #start_page QToolButton#first_entry:hover, #start_page QToolButton#first_entry:focus { background: #3a78b4; }
)";

QString rules_with(const Shades& s, double points) {
  QString rules = QString::fromLatin1(kRules);
  const std::pair<const char*, QColor> colours[] = {{"<window>", s.window},     {"<base>", s.base},
                                                    {"<raised>", s.raised},     {"<hover>", s.hover},
                                                    {"<checked>", s.checked},   {"<header>", s.header},
                                                    {"<line>", s.line},         {"<card>", s.card},
                                                    {"<text>", s.text},         {"<dim>", s.dim},
                                                    {"<accent>", s.accent},     {"<warning>", s.warning},
                                                    {"<disabled>", s.disabled}, {"<active_card>", s.active_card}};
  for (const auto& [name, colour] : colours) rules.replace(QLatin1String(name), colour.name());
  rules.replace("<small>", QString("%1pt").arg(0.85 * points, 0, 'f', 1));
  rules.replace("<large>", QString("%1pt").arg(1.6 * points, 0, 'f', 1));
  return rules;
}

}  // namespace

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

const Shades& shades() { return dark ? kDark : kLight; }
bool is_dark() { return dark; }

int scaled(int pixels) {
  // The default font (9 points at 96 dpi) has lines of 15 pixels; up to 16 pixels, lengths are not scaled.
  const double line = QFontMetrics(QApplication::font()).height();
  return static_cast<int>(std::lround(pixels * std::max(1.0, line / 16)));
}

void apply(QApplication& application, bool dark_theme, int text_percent) {
  if (usual_points <= 0) {
    usual_points = QApplication::font().pointSizeF();
    if (usual_points <= 0) usual_points = 9;
    application.setStyle(QStyleFactory::create("Fusion"));
  }
  dark = dark_theme;
  const Shades& s = shades();
  QFont font = QApplication::font();
  font.setPointSizeF(usual_points * text_percent / 100);
  QApplication::setFont(font);
  QPalette palette;
  palette.setColor(QPalette::Window, s.window);
  palette.setColor(QPalette::WindowText, s.text);
  palette.setColor(QPalette::Base, s.base);
  palette.setColor(QPalette::AlternateBase, s.window);
  palette.setColor(QPalette::Text, s.text);
  palette.setColor(QPalette::PlaceholderText, s.dim);
  palette.setColor(QPalette::Button, s.raised);
  palette.setColor(QPalette::ButtonText, s.text);
  palette.setColor(QPalette::BrightText, Qt::white);
  palette.setColor(QPalette::ToolTipBase, s.raised);
  palette.setColor(QPalette::ToolTipText, s.text);
  palette.setColor(QPalette::Link, s.accent);
  palette.setColor(QPalette::Highlight, QColor(48, 104, 160));
  palette.setColor(QPalette::HighlightedText, Qt::white);
  palette.setColor(QPalette::Light, s.raised.lighter(120));
  palette.setColor(QPalette::Midlight, s.raised.lighter(110));
  palette.setColor(QPalette::Mid, s.raised.darker(120));
  palette.setColor(QPalette::Dark, s.raised.darker(dark ? 200 : 150));
  palette.setColor(QPalette::Shadow, s.raised.darker(dark ? 300 : 200));
  for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText}) {
    palette.setColor(QPalette::Disabled, role, s.disabled);
  }
  palette.setColor(QPalette::Disabled, QPalette::Highlight, s.raised);
  QApplication::setPalette(palette);
  application.setStyleSheet(rules_with(s, font.pointSizeF()));
}

bool desktop_is_dark() {
  // Without a session bus, Qt would start one, which can take long.
  const bool has_bus = !qEnvironmentVariableIsEmpty("DBUS_SESSION_BUS_ADDRESS") ||
                       QFileInfo::exists(qEnvironmentVariable("XDG_RUNTIME_DIR", "/nowhere") + "/bus");
  if (!has_bus) return true;
  QDBusMessage request = QDBusMessage::createMethodCall(
      "org.freedesktop.portal.Desktop", "/org/freedesktop/portal/desktop", "org.freedesktop.portal.Settings", "Read");
  request << QString("org.freedesktop.appearance") << QString("color-scheme");
  constexpr int kTimeoutMs = 300;
  const QDBusMessage reply = QDBusConnection::sessionBus().call(request, QDBus::Block, kTimeoutMs);
  if (reply.type() != QDBusMessage::ReplyMessage || reply.arguments().isEmpty()) return true;
  QVariant value = reply.arguments().front();
  while (value.canConvert<QDBusVariant>()) value = value.value<QDBusVariant>().variant();
  constexpr uint kPrefersLight = 2;  // 1: dark; 0: no preference
  return value.toUInt() != kPrefersLight;
}

}  // namespace simplexseg::theme
