// SPDX-License-Identifier: Apache-2.0
// Each dialog of an action or panel has a title and a control with the keyboard focus. Esc closes it, nothing changes,
// and the window has the focus again.
#include <QAction>
#include <QDialog>
#include <QElapsedTimer>
#include <QFile>
#include <QMenu>
#include <QPushButton>
#include <QSettings>
#include <QTest>
#include <QTimer>

#include "gui/input/help.h"
#include "gui/panels/check_panel.h"
#include "gui/panels/convergence_panel.h"
#include "gui/panels/force_panel.h"
#include "gui/window/autosave.h"
#include "gui/window/file_actions.h"
#include "gui/window/label_dialog.h"
#include "gui/window/series_dialog.h"
#include "gui/workbench/background_job.h"
#include "io/volume/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

QDialog* open_dialog() {
  for (QWidget* widget : QApplication::topLevelWidgets())
    if (auto* dialog = qobject_cast<QDialog*>(widget); dialog && dialog->isVisible()) return dialog;
  return nullptr;
}

/// Whether Return or Space has an effect in the dialog.
bool takes_keys(const QDialog& dialog) {
  if (const QWidget* focus = dialog.focusWidget(); focus && focus->isEnabled() && focus->focusPolicy() != Qt::NoFocus)
    return true;
  for (const QPushButton* button : dialog.findChildren<QPushButton*>())
    if (button->isDefault() && button->isEnabled()) return true;
  return false;
}

class DialogsTest : public PausedPhantomTest {
 protected:
  struct Seen {
    int count = 0;
    QString title;
    bool keys = false;
  };

  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    ASSERT_TRUE(has_keys());
    axial().setFocus();
  }

  /// Calls `open`, which opens a dialog and may block until it is closed, and sends Esc to each dialog.
  static Seen open_and_escape(const std::function<void()>& open) {
    Seen seen;
    QTimer escape;
    QElapsedTimer since;
    since.start();
    const QDialog* escaped = nullptr;
    QObject::connect(&escape, &QTimer::timeout, [&] {
      QDialog* dialog = open_dialog();
      // A dialog that ignores the key would block the test forever.
      if (dialog && since.elapsed() > 8000) dialog->done(QDialog::Rejected);
      if (!dialog || dialog == escaped) return;
      escaped = dialog;
      ++seen.count;
      seen.title = dialog->windowTitle();
      seen.keys = takes_keys(*dialog);
      since.restart();
      QWidget* focus = dialog->focusWidget();
      QTest::keyClick(focus ? focus : dialog, Qt::Key_Escape);
    });
    escape.start(20);
    open();
    EXPECT_TRUE(wait_until([&] { return seen.count > 0 && !open_dialog(); })) << "no dialog, or it stays open";
    EXPECT_LT(since.elapsed(), 8000) << seen.title.toStdString() << " is not closed by Esc";
    return seen;
  }

  void expect_escaped(const char* what, const std::function<void()>& open) {
    SCOPED_TRACE(what);
    QWidget* const focus = window_->focusWidget();
    const SessionCount before = count();
    const Seen seen = open_and_escape(open);
    EXPECT_EQ(seen.count, 1);
    EXPECT_FALSE(seen.title.isEmpty());
    EXPECT_TRUE(seen.keys) << seen.title.toStdString();
    EXPECT_TRUE(window_->isVisible());
    EXPECT_EQ(count(), before) << seen.title.toStdString() << " had an effect although it was cancelled";
    ASSERT_TRUE(has_keys()) << seen.title.toStdString();
    EXPECT_EQ(window_->focusWidget(), focus) << seen.title.toStdString();
    // Keys act in the window again.
    const double slice = bench().view.crosshair_mm.z();
    QTest::keyClick(window_->focusWidget(), Qt::Key_PageUp);
    EXPECT_NE(bench().view.crosshair_mm.z(), slice) << seen.title.toStdString();
    QTest::keyClick(window_->focusWidget(), Qt::Key_PageDown);
  }

  using SessionCount = std::pair<std::size_t, std::size_t>;
  SessionCount count() { return {bench().session().log().size(), scene().meshes.size()}; }
};

TEST_F(DialogsTest, EachDialogOfAnActionIsClosedByEsc) {
  window_->panels().set_researcher(true);  // for Compare
  const Act acts[] = {Act::Open,         Act::OpenFolder, Act::OpenReference, Act::SaveScene,
                      Act::SaveSceneAs,  Act::SaveLabels, Act::SaveMeshes,    Act::MeshFromLabels,
                      Act::MeshFromFile, Act::Screenshot, Act::Help,          Act::Messages,
                      Act::About,        Act::Compare,    Act::Archive,       Act::ChangeKeys};
  for (const Act act : acts) {
    QAction* const action = window_->actions()[act];
    ASSERT_TRUE(action->isEnabled()) << binding_of(act).title;
    expect_escaped(binding_of(act).title, [action] { action->trigger(); });
  }
}

TEST_F(DialogsTest, EscInTheQuestionOnExitCancelsTheExit) {
  bench().apply(AddPoint{scene().meshes[0].id, bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 14)});
  bench().pause();
  bool cancelled = false;
  expect_escaped("exit", [&] { cancelled = !window_->files().may_discard(); });
  EXPECT_TRUE(cancelled);
  EXPECT_TRUE(bench().has_unsaved_changes());
}

TEST_F(DialogsTest, SelectionDialogsAreClosedByEsc) {
  const auto shown = [](QDialog* dialog) {
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->open();
  };
  FoundSeries found;
  for (const char* name : {"thin", "thick"}) {
    DicomSeries& series = found.series.emplace_back();
    series.uid = name, series.texts.series = name, series.files = 3;
    series.geometry.size = {9, 8, 3};
  }
  expect_escaped("series", [&] { shown(new SeriesDialog(found, window_.get())); });
  LabelCount label;
  label.value = 3;
  label.voxels = 500;
  expect_escaped("labels", [&] { shown(new LabelDialog({label}, window_.get())); });
  // A 4D file needs the number of a volume.
  Volume volume = make_phantom("sphere", {.size = 8}).image;
  const std::string file = folder_.filePath("four.nii").toStdString();
  write_volume(file, volume);
  QFile four(folder_.filePath("four.nii"));
  ASSERT_TRUE(four.open(QIODevice::ReadWrite));
  const QByteArray voxels = four.readAll().mid(352);
  four.seek(40);
  four.write(QByteArray::fromHex("0400080008000800020001000100"), 14);  // dim: 4, 8, 8, 8, 2, 1, 1
  four.seek(352 + voxels.size());
  four.write(voxels);
  four.close();
  expect_escaped("4D", [&] { window_->files().open(folder_.filePath("four.nii")); });
}

TEST_F(DialogsTest, FileDialogsOfPanelsAreClosedByEsc) {
  bench().advance_steps(5);  // a run that can be saved
  SidePanels& panels = window_->panels();
  const auto save_button = [](const QWidget& panel) {
    for (QPushButton* button : panel.findChildren<QPushButton*>())
      if (button->text().startsWith("Save")) return button;
    return static_cast<QPushButton*>(nullptr);
  };
  const std::pair<const char*, QWidget*> saving[] = {{"Check", &panels.check()},
                                                     {"Convergence", &panels.convergence()}};
  for (const auto& [title, panel] : saving) {
    panels.show_panel(title);
    QPushButton* const save = save_button(*panel);
    ASSERT_TRUE(save) << title;
    ASSERT_TRUE(wait_until([&] { return save->isEnabled(); })) << title;
    axial().setFocus();
    expect_escaped(title, [&] { save->click(); });
  }
  panels.show_panel("Forces");
  axial().setFocus();
  auto* const presets = panels.forces().findChild<QMenu*>("presets");
  ASSERT_TRUE(presets);
  emit presets->aboutToShow();  // fills the menu
  int dialogs = 0;
  for (QAction* action : presets->actions()) {
    if (!action->text().endsWith("...")) continue;
    ++dialogs;
    expect_escaped(action->text().toUtf8(), [&] { action->trigger(); });
  }
  EXPECT_EQ(dialogs, 2);
}

TEST_F(DialogsTest, TheRecoveryDialogIsPostponedByEsc) {
  const std::filesystem::path root = folder_.filePath("work").toStdString();
  const Scene work = scene();
  {
    AutosaveStore store(root);
    store.save(work, {"/images/ct.nii.gz", "", 1700000000});
    std::filesystem::copy(store.folder(), root / "window-killed", std::filesystem::copy_options::recursive);
  }
  auto autosave = std::make_unique<Autosave>(bench(), window_->files(), window_->job(), *window_, root);
  expect_escaped("recovery", [&] { autosave->offer_recovery(); });
  autosave.reset();
  EXPECT_EQ(find_recoverable_work(root).size(), 1u) << "it is offered again";
}

}  // namespace
}  // namespace simplexseg
