// SPDX-License-Identifier: Apache-2.0
// Themes, names for screen readers, reasons of disabled controls, and use by keyboard only.
#include <QAbstractButton>
#include <QAbstractItemView>
#include <QAbstractSpinBox>
#include <QAccessible>
#include <QAction>
#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QMenuBar>
#include <QSettings>
#include <QSignalSpy>
#include <QSlider>
#include <QStatusBar>
#include <QTabBar>
#include <QTest>
#include <QToolButton>
#include <cmath>
#include <set>

#include "gpu/backend.h"
#include "gui/look/theme.h"
#include "gui/panels/mesh_panel.h"
#include "gui/window/start_page.h"
#include "gui/window/theme_settings.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

/// Contrast ratio of WCAG 2, from 1 to 21.
double contrast(const QColor& a, const QColor& b) {
  const auto luminance = [](const QColor& colour) {
    const auto linear = [](double c) { return c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
    return 0.2126 * linear(colour.redF()) + 0.7152 * linear(colour.greenF()) + 0.0722 * linear(colour.blueF());
  };
  const double x = luminance(a), y = luminance(b);
  return (std::max(x, y) + 0.05) / (std::min(x, y) + 0.05);
}

class LookTest : public PausedPhantomTest {
 protected:
  void TearDown() override {
    if (qApp) theme::apply(*qApp, true);
    PausedPhantomTest::TearDown();
  }
  void show_everything() {
    bench().apply(AddMesh{"", Seed{bench().view.crosshair_mm, 6}, {}, 0});
    bench().pause();
    window_->panels().set_researcher(true);
    window_->actions()[Act::History]->trigger();
    window_->start_page().show_recent({});
    QApplication::processEvents();
  }
};

TEST_F(LookTest, BothThemesCanBeRead) {
  for (const bool dark : {true, false}) {
    theme::apply(*qApp, dark);
    EXPECT_EQ(theme::is_dark(), dark);
    const theme::Shades& s = theme::shades();
    for (const QColor& ground : {s.window, s.base, s.raised, s.hover, s.header, s.card, s.active_card})
      EXPECT_GE(contrast(s.text, ground), 4.5) << dark << ground.name().toStdString();
    EXPECT_GE(contrast(s.text, s.checked), 4.5);
    for (const QColor& ground : {s.window, s.base, s.header, s.card, s.active_card}) {
      EXPECT_GE(contrast(s.dim, ground), 4.5) << dark << ground.name().toStdString();
      EXPECT_GE(contrast(s.warning, ground), 4.5) << dark << ground.name().toStdString();
    }
    EXPECT_GE(contrast(s.accent, s.window), 3.0) << "the frame of the view with keyboard focus";
    QApplication::processEvents();
    // The area around the views follows the theme; the views are dark in both themes.
    const QImage picture = window_->grab().toImage();
    const QColor around = picture.pixelColor(window_->statusBar()->geometry().center());
    EXPECT_EQ(around.lightness() < 128, dark) << around.name().toStdString();
  }
}

TEST_F(LookTest, TheThemeIsRememberedAndFollowsTheDesktop) {
  const QTemporaryDir settings;
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, settings.path());
  {
    ThemeSettings look(*qApp);
    EXPECT_EQ(look.choice(), theme::Choice::Desktop);
    EXPECT_EQ(theme::is_dark(), theme::desktop_is_dark());
    look.choose(theme::Choice::Light);
    EXPECT_FALSE(theme::is_dark());
    QSignalSpy notes(&look, &ThemeSettings::message);
    look.choose_text(130);
    EXPECT_EQ(notes.count(), 1);
  }
  const double before = QApplication::font().pointSizeF();
  theme::apply(*qApp, true);
  ThemeSettings again(*qApp);
  EXPECT_EQ(again.choice(), theme::Choice::Light);
  EXPECT_FALSE(theme::is_dark());
  EXPECT_NEAR(QApplication::font().pointSizeF(), 1.3 * before, 0.01);
  EXPECT_GT(theme::scaled(100), 100);
  QMenu menu;
  again.fill(menu);
  EXPECT_EQ(menu.findChildren<QMenu*>().size(), 2);
  // A start with another theme keeps the text size and the saved theme.
  EXPECT_EQ(ThemeSettings(*qApp, theme::Choice::Dark).text_percent(), 130);
  EXPECT_TRUE(theme::is_dark());
  EXPECT_GT(theme::scaled(100), 100);
  EXPECT_EQ(ThemeSettings(*qApp).choice(), theme::Choice::Light);
  again.choose_text(100);
}

/// Whether a widget takes input or keyboard focus.
bool is_control(const QWidget& widget) {
  const QString type = widget.metaObject()->className();
  if (type.startsWith("QScrollBar") || type == "QMenu" || type == "QMenuBar" || type == "QToolBarExtension" ||
      type == "QComboBoxListView" || widget.objectName().startsWith("qt_"))
    return false;
  if (qobject_cast<const QLabel*>(&widget)) return false;                 // text that can be selected
  if (qobject_cast<const QTabBar*>(widget.parentWidget())) return false;  // arrows of the tab bar
  if (qobject_cast<const QLineEdit*>(&widget) && qobject_cast<const QAbstractSpinBox*>(widget.parentWidget()))
    return false;  // the spin box has the name
  if (qobject_cast<const QAbstractScrollArea*>(&widget) && !qobject_cast<const QAbstractItemView*>(&widget))
    return false;
  return widget.focusPolicy() != Qt::NoFocus || qobject_cast<const QAbstractButton*>(&widget) ||
         qobject_cast<const QSlider*>(&widget);
}

TEST_F(LookTest, EveryControlHasAName) {
  show_everything();
  int controls = 0;
  for (QWidget* widget : window_->findChildren<QWidget*>()) {
    if (!is_control(*widget)) continue;
    ++controls;
    QAccessibleInterface* accessible = QAccessible::queryAccessibleInterface(widget);
    ASSERT_NE(accessible, nullptr);
    EXPECT_FALSE(accessible->text(QAccessible::Name).trimmed().isEmpty())
        << widget->metaObject()->className() << " '" << widget->objectName().toStdString() << "' in "
        << widget->parentWidget()->metaObject()->className() << ", tooltip '" << widget->toolTip().toStdString() << "'";
  }
  EXPECT_GT(controls, 60);
}

TEST_F(LookTest, DisabledControlsGiveAReason) {
  const auto check = [&](const char* when) {
    for (const QAction* action : window_->findChildren<QAction*>()) {
      if (action->isEnabled() || action->isSeparator() || action->text().isEmpty()) continue;
      if (action->menu() && action->menu()->actions().isEmpty()) continue;  // an empty menu
      const bool has_reason = action->property("tooltip_when_enabled").isValid() && action->toolTip().size() > 10;
      EXPECT_TRUE(has_reason) << when << ": " << action->text().toStdString() << ": "
                              << action->toolTip().toStdString();
    }
    for (const QWidget* widget : window_->findChildren<QWidget*>()) {
      if (!is_control(*widget) || widget->isEnabledTo(widget->parentWidget())) continue;
      const auto* button = qobject_cast<const QToolButton*>(widget);
      if (button && button->defaultAction()) continue;  // checked above
      const bool has_reason = widget->property("tooltip_when_enabled").isValid() && widget->toolTip().size() > 10;
      EXPECT_TRUE(has_reason) << when << ": " << widget->metaObject()->className() << " "
                              << widget->accessibleName().toStdString() << ": " << widget->toolTip().toStdString();
    }
  };
  show_everything();
  check("with a mesh");
  bench().apply(EditMesh{bench().view.active_mesh, {}, {}, {}, {}, true});
  check("locked");
  show_window(make_cpu_engine(1), {});
  check("empty");
}

TEST_F(LookTest, TheTabKeyReachesEveryControl) {
  show_everything();
  ASSERT_TRUE(has_keys());
  std::set<const QWidget*> reached;
  window_->views().all()[0]->setFocus();
  for (int n = 0; n < 600; ++n) {
    QWidget* now = window_->focusWidget();
    ASSERT_NE(now, nullptr);
    if (!reached.insert(now).second && reached.size() > 30) break;
    QTest::keyClick(window_->windowHandle(), Qt::Key_Tab);
  }
  for (const QWidget* widget : window_->findChildren<QWidget*>()) {
    if (!is_control(*widget) || !widget->isVisible() || !widget->isEnabled() || widget->focusProxy()) continue;
    if (!(widget->focusPolicy() & Qt::TabFocus)) {
      // A key or a menu entry must exist for it.
      const auto* button = qobject_cast<const QToolButton*>(widget);
      const bool reachable = (button && button->defaultAction() && !button->defaultAction()->shortcut().isEmpty()) ||
                             widget->inherits("QTabBar");
      EXPECT_TRUE(reachable) << widget->metaObject()->className() << " " << widget->accessibleName().toStdString()
                             << " " << widget->objectName().toStdString();
      continue;
    }
    EXPECT_TRUE(reached.contains(widget))
        << widget->metaObject()->className() << " " << widget->accessibleName().toStdString();
  }
}

TEST_F(LookTest, AMeshIsSeededAndCorrectedByKeysAlone) {
  const std::size_t meshes = scene().meshes.size();
  auto* panel = window_->findChild<MeshPanel*>();
  QAbstractButton* add = nullptr;
  for (QAbstractButton* button : panel->findChildren<QAbstractButton*>())
    if (button->text().startsWith("Add seed")) add = button;
  add->setFocus();
  QTest::keyClick(add, Qt::Key_Space);
  ASSERT_EQ(scene().meshes.size(), meshes + 1);
  QWidget& view = axial();
  view.setFocus();
  ASSERT_TRUE(has_keys());
  const auto key = [&](int code, Qt::KeyboardModifiers modifiers = {}) {
    QTest::keyClick(window_->windowHandle(), static_cast<Qt::Key>(code), modifiers);
  };
  for (const auto& [code, kind] :
       {std::pair{Qt::Key_I, MarkKind::Inside}, {Qt::Key_O, MarkKind::Outside}, {Qt::Key_B, MarkKind::Boundary}}) {
    key(Qt::Key_Right), key(Qt::Key_Right);
    const std::size_t points = scene().points.size();
    key(code, Qt::ShiftModifier);
    ASSERT_EQ(scene().points.size(), points + 1);
    EXPECT_EQ(scene().points.back().kind, kind);
    EXPECT_EQ(scene().points.back().position_mm, bench().view.crosshair_mm);
  }
  key(Qt::Key_Up);
  key(Qt::Key_M, Qt::ShiftModifier);
  EXPECT_EQ(scene().points.back().position_mm, bench().view.crosshair_mm);
  key(Qt::Key_Delete);
  EXPECT_EQ(scene().points.size(), 2u);
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(scene().points.size(), 3u);
}

TEST_F(LookTest, TheViewWithFocusHasAFrame) {
  theme::apply(*qApp, true);
  ASSERT_TRUE(has_keys());
  axial().setFocus();
  QApplication::processEvents();
  const auto has_frame = [&](const QWidget& view) {
    const QImage picture = window_->views().grab().toImage();
    const QPoint left = view.mapTo(&window_->views(), QPoint(0, view.height() / 2));
    return picture.pixelColor(left - QPoint(1, 0)) == theme::shades().accent;
  };
  EXPECT_TRUE(has_frame(axial()));
  window_->views().slice(1).setFocus();
  QApplication::processEvents();
  EXPECT_FALSE(has_frame(axial()));
}

}  // namespace
}  // namespace simplexseg
