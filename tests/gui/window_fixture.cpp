// SPDX-License-Identifier: Apache-2.0
#include "window_fixture.h"

#include <QAbstractButton>
#include <QAbstractSpinBox>
#include <QAccessible>
#include <QComboBox>
#include <QDialog>
#include <QElapsedTimer>
#include <QFileInfo>
#include <QLineEdit>
#include <QOpenGLContext>
#include <QTest>
#include <QTreeWidget>
#include <QWheelEvent>

#include "gpu/backend.h"
#include "gui/window/startup.h"
#include "gui/workbench/background_job.h"
#include "io/model/model_file.h"
#include "model/model_training.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

// Destroyed before main() returns: Qt cannot release its OpenGL contexts during static destruction.
std::unique_ptr<QApplication> application;
struct EndOfApplication : ::testing::Environment {
  void TearDown() override { application.reset(); }
};
[[maybe_unused]] const auto* const end_of_application =
    ::testing::AddGlobalTestEnvironment(new EndOfApplication);  // GoogleTest owns it

}  // namespace

std::string why_no_window() {
  static const std::string why = []() -> std::string {
    const QString display = qEnvironmentVariable("DISPLAY");
    if (display.isEmpty()) return "no DISPLAY";
    // Qt aborts if a local display does not respond; check its socket first.
    if (display.startsWith(':') && !QFileInfo::exists("/tmp/.X11-unix/X" + display.mid(1).section('.', 0, 0))) {
      return "no response from DISPLAY " + display.toStdString();
    }
    static int count = 1;
    static char name[] = "gui_test";
    static char* arguments[] = {name, nullptr};
    set_surface_format();
    application = std::make_unique<QApplication>(count, arguments);
    return why_no_opengl();
  }();
  return why;
}

bool wait_until(const std::function<bool()>& done) {
  QElapsedTimer timer;
  timer.start();
  while (!done()) {
    if (timer.elapsed() > 10000) return false;
    QApplication::processEvents(QEventLoop::AllEvents | QEventLoop::WaitForMoreEvents, 20);
  }
  return true;
}

int check_controls(const QDialog& dialog) {
  int controls = 0;
  for (QWidget* widget : dialog.findChildren<QWidget*>()) {
    if (!widget->isVisible() || widget->window() != &dialog) continue;
    const bool is_line = qobject_cast<QLineEdit*>(widget) && !qobject_cast<QAbstractSpinBox*>(widget->parentWidget()) &&
                         !qobject_cast<QComboBox*>(widget->parentWidget());
    if (!qobject_cast<QAbstractButton*>(widget) && !qobject_cast<QComboBox*>(widget) && !is_line &&
        !qobject_cast<QTreeWidget*>(widget) && !qobject_cast<QAbstractSpinBox*>(widget))
      continue;
    ++controls;
    EXPECT_FALSE(QAccessible::queryAccessibleInterface(widget)->text(QAccessible::Name).trimmed().isEmpty())
        << widget->metaObject()->className() << " " << widget->toolTip().toStdString();
    EXPECT_TRUE(dialog.rect().contains(QRect(widget->mapTo(&dialog, QPoint()), widget->size())))
        << widget->accessibleName().toStdString();
    EXPECT_TRUE(widget->isEnabled() || widget->toolTip().size() > 10)
        << widget->objectName().toStdString() << " does not explain why it is disabled";
  }
  return controls;
}

void WindowTest::SetUp() {
  if (const std::string why = why_no_window(); !why.empty()) GTEST_SKIP() << "no window: " << why;
  show_window(make_cpu_engine(1), {});
}

void WindowTest::show_window(std::unique_ptr<Engine> engine, std::function<std::unique_ptr<Engine>()> make_fallback) {
  window_ = std::make_unique<MainWindow>(std::move(engine), std::move(make_fallback));
  window_->set_unattended();
  window_->resize(1200, 800);
  window_->show();
  QApplication::processEvents();
}

void WindowTest::TearDown() { window_.reset(); }

bool WindowTest::has_keys() {
  window_->activateWindow();
  return QTest::qWaitForWindowActive(window_.get());
}

void PausedPhantomTest::choose_entry(const std::vector<QMenu*>& menus, const QString& title) {
  for (QMenu* menu : menus)
    for (QAction* entry : menu->actions())
      if (entry->text().remove('&') == title) {
        entry->trigger();
        EXPECT_TRUE(entry->isChecked()) << title.toStdString();
        for (int n = 0; n < 5; ++n) QApplication::processEvents();
        return;
      }
  FAIL() << title.toStdString();
}

void PausedPhantomTest::SetUp() {
  WindowTest::SetUp();
  if (IsSkipped()) return;
  open_phantom();
  bench().pause();
}

bool WindowTest::wait_for_job() {
  return wait_until([&] { return !window_->job().busy(); });
}

int WindowTest::count_pixels(const QColor& colour) {
  const QImage picture = axial().grabFramebuffer();
  int count = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) count += picture.pixelColor(x, y) == colour;
  return count;
}

void WindowTest::open_phantom(double radius_mm) {
  Phantom phantom = make_phantom("sphere", {});
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem item;
  item.name = "object";
  item.seed = {phantom.image.geometry().centre_mm(), radius_mm};
  item.parameters = default_force_parameters();
  for (const ForceInfo& force : force_list()) item.parameters.values[static_cast<int>(force.id)][0] = 0;
  item.parameters.values[static_cast<int>(ForceId::Smoothing)][0] = 0.5f;
  item.parameters.values[static_cast<int>(ForceId::Attraction)][0] = 1;
  scene.meshes.push_back(item);
  bench().open(std::move(scene), phantom.image);
  QApplication::processEvents();
}

void WindowTest::mouse(QWidget& widget, QEvent::Type type, const QPointF& at, Qt::MouseButton button,
                       Qt::MouseButtons held, Qt::KeyboardModifiers modifiers) {
  QMouseEvent event(type, at, widget.mapToGlobal(at), button, held, modifiers);
  QApplication::sendEvent(&widget, &event);
}

void WindowTest::drag(QWidget& widget, const QPointF& from, const QPointF& to, Qt::MouseButton button,
                      Qt::KeyboardModifiers modifiers) {
  drag(widget, {from, to}, button, modifiers);
}

void WindowTest::drag(QWidget& widget, const std::vector<QPointF>& path, Qt::MouseButton button,
                      Qt::KeyboardModifiers modifiers) {
  mouse(widget, QEvent::MouseButtonPress, path.front(), button, button, modifiers);
  constexpr int kMoves = 8;
  for (std::size_t p = 1; p < path.size(); ++p)
    for (int n = 1; n <= kMoves; ++n)
      mouse(widget, QEvent::MouseMove, path[p - 1] + (path[p] - path[p - 1]) * n / kMoves, Qt::NoButton, button,
            modifiers);
  mouse(widget, QEvent::MouseButtonRelease, path.back(), button, Qt::NoButton, modifiers);
}

bool WindowTest::share_contexts(const View& a, const View& b) {
  return QOpenGLContext::areSharing(a.context(), b.context());
}

void WindowTest::wheel(QWidget& widget, const QPointF& at, int notches, Qt::KeyboardModifiers modifiers) {
  QWheelEvent event(at, widget.mapToGlobal(at), {}, {0, 120 * notches}, Qt::NoButton, modifiers, Qt::NoScrollPhase,
                    false);
  QApplication::sendEvent(&widget, &event);
}

std::string write_sphere_model(const QString& path) {
  const Phantom phantom = make_phantom("sphere", {});
  const std::vector<ModelCase> cases{{"sphere", phantom.image, mask_of(phantom.labels, 1.0), {}}};
  const TrainingSettings settings{.vertices = 200, .modes = 5};
  ModelFile file;
  file.organs.push_back(train_model(register_cases(cases, settings, run_serially()), settings, run_serially()));
  write_model(path.toStdString(), file);
  return file.checksum;
}

}  // namespace simplexseg

#ifdef __SANITIZE_THREAD__
// Qt and OpenGL drivers are not instrumented, so that data protected by their locks is reported as a race: for example
// events and functions posted from one thread to another.
extern "C" __attribute__((visibility("default"))) const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }
extern "C" __attribute__((visibility("default"))) const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:QFunctorSlotObject\nrace:_M_create<simplexseg::Workbench::begin_advance\n";
}
#endif
