// SPDX-License-Identifier: Apache-2.0
// Random events: the window survives, and every action can be undone. SIMPLEXSEG_EVENTS sets the number of events
// (default 200), SIMPLEXSEG_SEED the random seed (default 0).
#include <QContextMenuEvent>
#include <QKeySequence>
#include <QTest>
#include <QTimer>
#include <iostream>
#include <random>

#include "forces/force_list.h"
#include "gui/input/bindings.h"
#include "gui/views/drawn_scene.h"
#include "mesh/simplex_mesh.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

class RandomEventsTest : public PausedPhantomTest {
 protected:
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  Qt::KeyboardModifiers any_modifiers() {
    Qt::KeyboardModifiers modifiers;
    for (const Qt::KeyboardModifier one : {Qt::ShiftModifier, Qt::ControlModifier, Qt::AltModifier})
      if (below(5) == 0) modifiers |= one;
    return modifiers;
  }
  /// Closes menus and dialogs that have opened, so that they do not block the next event.
  static void close_dialogs() {
    if (QWidget* popup = QApplication::activePopupWidget()) popup->close();
    if (QWidget* dialog = QApplication::activeModalWidget()) dialog->close();
  }
  void random_mouse_event() {
    QWidget& view = *window_->views().all()[static_cast<std::size_t>(below(4))];
    const auto place = [&] { return QPointF(below(view.width() + 40) - 20, below(view.height() + 40) - 20); };
    const QPointF from = place(), to = below(2) ? place() : from + QPointF(below(40) - 20, below(40) - 20);
    const Qt::MouseButton buttons[] = {Qt::LeftButton, Qt::LeftButton, Qt::LeftButton, Qt::RightButton,
                                       Qt::MiddleButton};
    const Qt::MouseButton button = buttons[below(5)];
    const Qt::KeyboardModifiers modifiers = any_modifiers();
    switch (below(8)) {
      case 0:
        return wheel(view, from, below(7) - 3, modifiers);
      case 1:
        return mouse(view, QEvent::MouseMove, from, Qt::NoButton, Qt::NoButton, modifiers);
      case 2:
        return mouse(view, QEvent::MouseButtonDblClick, from, button, button, modifiers);
      case 3:  // a press without a release, or a release without a press
        return mouse(view, below(2) ? QEvent::MouseButtonPress : QEvent::MouseButtonRelease, from, button,
                     below(2) ? button : Qt::NoButton, modifiers);
      default:
        return drag(view, from, to, button, modifiers);
    }
  }
  /// Presses a random key of the table of bindings, except those that open file dialogs or end the program.
  void random_key_of_the_table() {
    const Binding& binding = bindings()[static_cast<std::size_t>(below(static_cast<int>(bindings().size())))];
    if (!*binding.keys) return;
    for (const Act act :
         {Act::Open, Act::OpenFolder, Act::SaveScene, Act::SaveSceneAs, Act::SaveLabels, Act::SaveMeshes,
          Act::Screenshot, Act::Quit, Act::Help, Act::About, Act::Messages, Act::Archive, Act::ChangeKeys})
      if (binding.act == act) return;
    if (binding.act == Act::RefineMesh && vertices() > 5000) return;
    const QKeyCombination keys = QKeySequence(QString::fromLatin1(binding.keys))[0];
    QTest::keyClick(window_->windowHandle(), keys.key(), keys.keyboardModifiers());
  }
  int vertices() {
    int count = 0;
    for (const MeshItem& item : bench().scene().meshes) count += item.mesh.vertex_count();
    return count;
  }

  std::mt19937 random_;
};

TEST_F(RandomEventsTest, TheWindowSurvivesAndAllActionsAreUndone) {
  const int events =
      qEnvironmentVariableIsSet("SIMPLEXSEG_EVENTS") ? qEnvironmentVariableIntValue("SIMPLEXSEG_EVENTS") : 200;
  random_.seed(static_cast<unsigned>(qEnvironmentVariableIntValue("SIMPLEXSEG_SEED")));
  ASSERT_TRUE(has_keys());
  // Without an image force, smoothing must preserve the volume: the steps of a long event would shrink the mesh to a
  // point.
  bench().apply(SetForceParameter{0, ForceId::Smoothing, SmoothingForce::curvature, 1});
  QTimer closer;
  QObject::connect(&closer, &QTimer::timeout, &RandomEventsTest::close_dialogs);
  closer.start(5);
  for (int n = 0; n < events; ++n) {
    below(3) ? random_mouse_event() : random_key_of_the_table();
    if (n % 4 == 0) QApplication::processEvents();
    // More meshes would only slow down the test.
    while (bench().scene().meshes.size() > 6) bench().apply(DeleteMesh{bench().scene().meshes.back().id});
    if (events > 2000 && n % 1000 == 999) std::cout << n + 1 << " events, " << scene().meshes.size() << " meshes\n";
  }
  bench().pause();
  close_dialogs();
  for (const MeshItem& item : scene().meshes) EXPECT_NO_THROW(validate(item.mesh)) << item.name;
  int undone = 0;
  while (bench().session().can_undo() && undone < 300) {
    ASSERT_TRUE(bench().apply(Undo{}));
    ++undone;
  }
  EXPECT_FALSE(bench().session().can_undo());
  while (bench().session().can_redo()) ASSERT_TRUE(bench().apply(Redo{}));
  for (const MeshItem& item : scene().meshes) EXPECT_NO_THROW(validate(item.mesh)) << item.name;
}

// Found by the test above: a press in a slice that was hidden when the active mesh was added.
TEST_F(RandomEventsTest, AnOutdatedSliceHasNoContourOfAnAddedMesh) {
  SliceView& coronal = window_->views().slice(2);
  const auto pieces = [&](int mesh) {
    coronal.makeCurrent();
    const std::size_t count = window_->drawn().buffers().read_outline(Orientation::Coronal, mesh).size();
    coronal.doneCurrent();
    return count;
  };
  ASSERT_TRUE(wait_until([&] { return pieces(0) > 0; }));
  mouse(axial(), QEvent::MouseButtonDblClick, QPointF(50, 50), Qt::LeftButton, Qt::LeftButton);
  ASSERT_FALSE(coronal.isVisible());
  bench().apply(AddMesh{"", Seed{bench().view.crosshair_mm, 6}, {}, 0});
  bench().pause();
  axial().grabFramebuffer();  // draws the new mesh, in this view alone
  EXPECT_EQ(pieces(1), 0u);
  EXPECT_NO_THROW(drag(coronal, QPointF(50, 50), QPointF(70, 60)));
}

}  // namespace
}  // namespace simplexseg
