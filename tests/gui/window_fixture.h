// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <QApplication>
#include <QDialog>
#include <QMenu>
#include <QMouseEvent>
#include <QTemporaryDir>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gui/input/action_table.h"
#include "gui/views/slice_view.h"
#include "gui/views/view_grid.h"
#include "gui/window/main_window.h"
#include "gui/window/side_panels.h"
#include "gui/workbench/workbench.h"
#include "study/phantom.h"

namespace simplexseg {

/// Creates the QApplication of the test program. Returns the reason why no window can be opened; empty if one can.
std::string why_no_window();

/// Processes events until `done` returns true, for ten seconds at most. Returns whether it did.
bool wait_until(const std::function<bool()>& done);

/// Requires of each visible control of a dialog that it has an accessible name, lies within the dialog, and explains
/// why it is disabled. Returns the number of controls.
int check_controls(const QDialog& dialog);

/// Window with a small phantom: a bright sphere of radius about 16 mm in 64^3 voxels of 1 mm.
class WindowTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
  /// Replaces the window.
  void show_window(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback);

  /// Opens the phantom with one mesh "object" of this radius at the centre; only attraction and smoothing move it.
  void open_phantom(double radius_mm = 12);
  Workbench& bench() { return window_->workbench(); }
  const Scene& scene() { return bench().session().scene(); }
  SliceView& axial() { return window_->views().slice(0); }
  /// Waits until the background job has ended; returns whether it has.
  bool wait_for_job();
  /// Number of pixels of this colour in the axial view.
  int count_pixels(const QColor& colour);

  static void mouse(QWidget& widget, QEvent::Type type, const QPointF& at, Qt::MouseButton button,
                    Qt::MouseButtons held, Qt::KeyboardModifiers modifiers = {});
  /// Sends a press, some moves and a release.
  static void drag(QWidget& widget, const QPointF& from, const QPointF& to, Qt::MouseButton button = Qt::LeftButton,
                   Qt::KeyboardModifiers modifiers = {});
  /// Sends a press, moves along a path of at least two places, and a release.
  static void drag(QWidget& widget, const std::vector<QPointF>& path, Qt::MouseButton button = Qt::LeftButton,
                   Qt::KeyboardModifiers modifiers = {});
  static bool share_contexts(const View& a, const View& b);
  static void wheel(QWidget& widget, const QPointF& at, int notches, Qt::KeyboardModifiers modifiers = {});

  /// Activates the window and returns whether it has the keyboard focus. A display has one focus for all windows: tests
  /// that call this are listed under KEYBOARD in tests/CMakeLists.txt.
  bool has_keys();

  QTemporaryDir folder_;
  std::unique_ptr<MainWindow> window_;
};

/// Window with the phantom open and paused.
class PausedPhantomTest : public WindowTest {
 protected:
  void SetUp() override;
  void press(Act act) { window_->actions()[act]->trigger(); }
  /// Pixel of the axial view at an offset from the crosshair along the axes x and y, mm.
  QPointF pixel(double x_mm, double y_mm) {
    return axial().pixel_of(bench().view.crosshair_mm + Eigen::Vector3d(x_mm, y_mm, 0));
  }
  /// Chooses the entry with this title in the first of several menus that has it.
  void choose_entry(const std::vector<QMenu*>& menus, const QString& title);
};

/// Trains a model of five modes from the phantom and writes it. Returns its checksum.
std::string write_sphere_model(const QString& path);

}  // namespace simplexseg
