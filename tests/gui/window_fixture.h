// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <QApplication>
#include <QMouseEvent>
#include <QTemporaryDir>
#include <functional>
#include <memory>
#include <string>

#include "gui/input/action_table.h"
#include "gui/views/slice_view.h"
#include "gui/views/view_grid.h"
#include "gui/window/main_window.h"
#include "gui/window/side_panels.h"
#include "gui/workbench/workbench.h"
#include "study/phantom.h"

namespace simplexseg {

/// Makes the QApplication of the test program. Why no window can be had, empty when one can.
std::string why_no_window();

/// Handles events until `done`, for ten seconds at most; returns whether it was.
bool wait_until(const std::function<bool()>& done);

/// A window on a small phantom: a bright sphere of radius about 16 mm in 64^3 voxels of 1 mm.
class WindowTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
  /// In place of the one that is.
  void show_window(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> spare);

  /// With one mesh "object" of this radius about the volume's centre, that only attraction and smoothing move.
  void open_phantom(double radius_mm = 12);
  Workbench& bench() { return window_->workbench(); }
  const Scene& scene() { return bench().session().scene(); }
  SliceView& axial() { return window_->views().slice(0); }

  static void mouse(QWidget& widget, QEvent::Type type, const QPointF& at, Qt::MouseButton button,
                    Qt::MouseButtons held, Qt::KeyboardModifiers modifiers = {});
  /// Press, some moves, release.
  static void drag(QWidget& widget, const QPointF& from, const QPointF& to, Qt::MouseButton button = Qt::LeftButton,
                   Qt::KeyboardModifiers modifiers = {});
  static bool share_contexts(const View& a, const View& b);
  static void wheel(QWidget& widget, const QPointF& at, int notches, Qt::KeyboardModifiers modifiers = {});

  /// Whether the window has the keyboard from here on. A display has one for all windows: a test that calls this is
  /// named in tests/CMakeLists.txt among those beside which none runs.
  bool has_keys();

  QTemporaryDir folder_;
  std::unique_ptr<MainWindow> window_;
};

/// The same with the phantom open, paused.
class PausedPhantomTest : public WindowTest {
 protected:
  void SetUp() override;
};

}  // namespace simplexseg
