// SPDX-License-Identifier: Apache-2.0
// Autosave after each action until the work is saved, and recovery after a crash. A scripted program is killed at
// random moments, SIMPLEXSEG_KILLS times (default 2).
#include <signal.h>

#include <QDialog>
#include <QFile>
#include <QListWidget>
#include <QMessageBox>
#include <QProcess>
#include <QPushButton>
#include <QSignalSpy>
#include <QTimer>
#include <iostream>
#include <map>
#include <random>

#include "gpu/backend.h"
#include "gui/window/autosave.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"
#include "io/scene/recovery.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

constexpr const char* kScript = "SIMPLEXSEG_SCRIPTED_SESSION";

std::unique_ptr<Autosave> autosave_of(MainWindow& window, const QString& folder) {
  return std::make_unique<Autosave>(window.workbench(), window.files(), window.job(), window,
                                    (folder + "/work").toStdString());
}

/// Program that is killed: opens ball.nii in its folder, adds meshes by mouse until it is killed, and prints their
/// number at each autosave.
void run_scripted_session(const QString& folder) {
  if (!why_no_window().empty()) return;
  MainWindow window(make_cpu_engine(1));
  window.set_unattended();
  window.resize(900, 700);
  window.show();
  const auto autosave = autosave_of(window, folder);
  const std::string volume = (folder + "/ball.nii").toStdString();
  window.files().open_loaded(load_input(volume), volume);
  std::map<std::uint64_t, std::size_t> meshes{{0, 0}};  // revision: number of meshes from then on
  QObject::connect(&window.workbench(), &Workbench::acted, [&] {
    meshes.emplace(window.workbench().session().revision(), window.workbench().scene().meshes.size());
  });
  QObject::connect(autosave.get(), &Autosave::saved, [&](quint64 revision) {
    const std::vector<RecoverableWork> none = find_recoverable_work((folder + "/work").toStdString());
    std::cout << "saved " << std::prev(meshes.upper_bound(revision))->second << std::endl;
    if (!none.empty()) std::cout << "offered by a running program" << std::endl;
  });
  std::mt19937 random(static_cast<unsigned>(QCoreApplication::applicationPid()));
  const auto somewhere = [&random] { return static_cast<double>(random() % 30) - 15; };
  QTimer script;
  QObject::connect(&script, &QTimer::timeout, [&] {
    Workbench& bench = window.workbench();
    SliceView& view = window.views().slice(0);
    const auto send = [&view](QEvent::Type type, const QPointF& at, Qt::MouseButtons held) {
      QMouseEvent event(type, at, view.mapToGlobal(at), Qt::LeftButton, held, Qt::NoModifier);
      QApplication::sendEvent(&view, &event);
    };
    const QPointF at = view.pixel_of(bench.view.crosshair_mm) + QPointF(somewhere() * 4, somewhere() * 4),
                  edge = at + QPointF(18, 0);
    window.actions()[Act::ToolSeed]->trigger();
    send(QEvent::MouseButtonPress, at, Qt::LeftButton);
    send(QEvent::MouseMove, edge, Qt::LeftButton);
    send(QEvent::MouseButtonRelease, edge, Qt::NoButton);
    std::cout << "acted " << bench.scene().meshes.size() << std::endl;
  });
  script.start(450 + static_cast<int>(random() % 300));
  QApplication::exec();
}

struct ScriptedSession : ::testing::Environment {
  void SetUp() override {
    if (qEnvironmentVariableIsSet(kScript)) run_scripted_session(qEnvironmentVariable(kScript));
  }
};
[[maybe_unused]] const auto* const scripted_session = ::testing::AddGlobalTestEnvironment(new ScriptedSession);

class AutosaveTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    write_volume(folder_.filePath("ball.nii").toStdString(), make_phantom("sphere", {}).image);
  }
  std::filesystem::path root() const { return folder_.filePath("work").toStdString(); }
  void open_ball() {
    const std::string path = folder_.filePath("ball.nii").toStdString();
    window_->files().open_loaded(load_input(path), path);
  }
  ItemId add_mesh() {
    ItemId mesh = 0;
    bench().pause();
    bench().apply(AddMesh{"", Seed{bench().view.crosshair_mm, 6}, {}, 0}, &mesh);
    return mesh;
  }
  /// Copies the current autosave to the place where a killed program leaves it.
  void leave_as_if_killed() {
    for (const auto& entry : std::filesystem::directory_iterator(root()))
      if (std::filesystem::exists(entry.path() / "work.json"))
        std::filesystem::copy(entry.path(), root() / "window-killed", std::filesystem::copy_options::recursive);
  }
  bool is_autosaved() const {
    for (const auto& entry : std::filesystem::directory_iterator(root()))
      if (std::filesystem::exists(entry.path() / "work.json")) return true;
    return false;
  }
};

TEST_F(AutosaveTest, WorkIsAutosavedAfterEachActionUntilItIsSaved) {
  EXPECT_LE(Autosave::kEveryMs, 60'000);
  auto autosave = autosave_of(*window_, folder_.path());
  open_ball();
  QSignalSpy saves(autosave.get(), &Autosave::saved);
  EXPECT_FALSE(is_autosaved());
  const ItemId mesh = add_mesh();
  for (int n = 0; n < 5; ++n) bench().apply(MovePoint{mesh, {0, 0, 0}, true});  // refused: not an action
  ASSERT_TRUE(wait_until([&] { return saves.count() == 1; })) << "automatically";
  EXPECT_TRUE(is_autosaved());
  autosave->save_now();
  for (int n = 0; n < 20; ++n) QApplication::processEvents();
  EXPECT_EQ(saves.count(), 1) << "nothing has changed";
  bench().advance_steps(3);
  autosave->save_now();  // as the timer does every minute
  ASSERT_TRUE(wait_until([&] { return saves.count() == 2; }));
  ASSERT_TRUE(window_->files().save_scene_to(folder_.filePath("mine.json")));
  ASSERT_TRUE(wait_until([&] { return !is_autosaved(); })) << "saved: nothing to recover";
  add_mesh();
  ASSERT_TRUE(wait_until([&] { return is_autosaved(); }));
  autosave.reset();
  EXPECT_TRUE(std::filesystem::is_empty(root())) << "regular end";
}

TEST_F(AutosaveTest, RecoveredWorkIsRestoredAsUnsaved) {
  auto autosave = autosave_of(*window_, folder_.path());
  open_ball();
  add_mesh();
  ASSERT_TRUE(window_->files().save_scene_to(folder_.filePath("mine.json")));
  const ItemId mesh = add_mesh();
  bench().apply(AddPoint{mesh, bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 3)});
  bench().advance_steps(4);
  bench().view.window = 321, bench().view.level = 123;
  autosave->save_now();
  ASSERT_TRUE(wait_until([&] { return is_autosaved(); }));
  const std::vector<Eigen::Vector3f> pose = scene().meshes[1].mesh.positions;
  const std::vector<std::string> done = bench().session().history().undo_names();
  leave_as_if_killed();
  autosave.reset();
  open_phantom();
  autosave = autosave_of(*window_, folder_.path());
  autosave->offer_recovery();
  ASSERT_NE(autosave->dialog(), nullptr);
  auto* list = autosave->dialog()->findChild<QListWidget*>();
  ASSERT_EQ(list->count(), 1);
  const QString line = list->item(0)->text();
  for (const char* part : {"mine.json", "2 segmentations", "1 point", "ago"}) EXPECT_TRUE(line.contains(part)) << part;
  QPushButton* restore = nullptr;
  for (QPushButton* button : autosave->dialog()->findChildren<QPushButton*>()) {
    EXPECT_TRUE(button->text().contains('&')) << button->text().toStdString();
    if (button->isDefault()) restore = button;
  }
  ASSERT_NE(restore, nullptr);
  QKeyEvent enter(QEvent::KeyPress, Qt::Key_Return, Qt::NoModifier);
  QApplication::sendEvent(restore, &enter);
  ASSERT_TRUE(wait_until([&] { return scene().meshes.size() == 2; }));
  EXPECT_EQ(scene().meshes[1].mesh.positions, pose);
  EXPECT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(bench().session().history().undo_names(), done) << "it can be undone";
  EXPECT_EQ(bench().view.window, 321);
  EXPECT_EQ(bench().view.level, 123);
  EXPECT_TRUE(bench().has_unsaved_changes());
  EXPECT_EQ(window_->files().scene_path(), folder_.filePath("mine.json")) << "Ctrl+S saves to the user's file";
  ASSERT_TRUE(wait_until([&] { return !std::filesystem::exists(root() / "window-killed"); }));
  EXPECT_TRUE(is_autosaved()) << "now by this window";
}

TEST_F(AutosaveTest, DiscardedWorkIsDeletedAndOpenWindowsKeepTheirs) {
  auto autosave = autosave_of(*window_, folder_.path());
  open_ball();
  add_mesh();
  autosave->save_now();
  ASSERT_TRUE(wait_until([&] { return is_autosaved(); }));
  MainWindow other(make_cpu_engine(1));
  auto others = autosave_of(other, folder_.path());
  others->offer_recovery();
  EXPECT_EQ(others->dialog(), nullptr) << "its window is open";
  leave_as_if_killed();
  others->offer_recovery();
  ASSERT_NE(others->dialog(), nullptr);
  autosave->offer_recovery();
  EXPECT_EQ(autosave->dialog(), nullptr) << "the other window has locked it";
  for (QPushButton* button : others->dialog()->findChildren<QPushButton*>())
    if (button->text().contains("Discard")) button->click();
  EXPECT_FALSE(std::filesystem::exists(root() / "window-killed"));
}

TEST_F(AutosaveTest, TheQuestionOnExitHasAMnemonicForEachButton) {
  open_ball();
  add_mesh();
  QStringList texts;
  const auto discards_with = [&](const QString& chosen) {
    QTimer::singleShot(0, [&texts, chosen] {
      auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
      ASSERT_NE(box, nullptr);
      for (QAbstractButton* button : box->buttons()) {
        texts << button->text();
        if (button->text() == chosen) QTimer::singleShot(0, button, &QAbstractButton::click);
      }
    });
    return window_->files().may_discard();
  };
  EXPECT_FALSE(discards_with("&Cancel"));
  EXPECT_TRUE(discards_with("&Discard"));
  for (const char* text : {"&Save", "&Discard", "&Cancel"}) EXPECT_TRUE(texts.contains(text)) << text;
}

TEST_F(AutosaveTest, WorkOfAKilledProgramIsRestoredCompletely) {
  const int kills =
      qEnvironmentVariableIntValue("SIMPLEXSEG_KILLS") > 0 ? qEnvironmentVariableIntValue("SIMPLEXSEG_KILLS") : 2;
  std::mt19937 random(std::random_device{}());
  for (int n = 0; n < kills; ++n) {
    std::filesystem::remove_all(root());
    QProcess session;
    QProcessEnvironment variables = QProcessEnvironment::systemEnvironment();
    variables.insert(kScript, folder_.path());
    for (const char* shard : {"GTEST_TOTAL_SHARDS", "GTEST_SHARD_INDEX"}) variables.remove(shard);
    session.setProcessEnvironment(variables);
    session.start(QCoreApplication::applicationFilePath(), {"--gtest_filter=Bindings.HelpListsEveryRow"});
    QByteArray output;
    ASSERT_TRUE(wait_until([&] {
      output += session.readAllStandardOutput();
      return output.contains("saved");
    })) << output.toStdString();
    // Kills the program at a random moment of the next action or its autosave.
    const int pause_ms = static_cast<int>(random() % (kills > 2 ? 4000 : 700));
    QElapsedTimer timer;
    timer.start();
    while (timer.elapsed() < pause_ms) {
      QApplication::processEvents(QEventLoop::AllEvents | QEventLoop::WaitForMoreEvents, 5);
      output += session.readAllStandardOutput();
    }
    ::kill(static_cast<pid_t>(session.processId()), SIGKILL);
    session.waitForFinished();
    ASSERT_EQ(session.exitStatus(), QProcess::CrashExit);
    EXPECT_FALSE(output.contains("offered by")) << output.toStdString();
    const int known = output.mid(output.lastIndexOf("saved ") + 6).split('\n').first().toInt();
    output += session.readAllStandardOutput();
    const int acted = output.mid(output.lastIndexOf("acted ") + 6).split('\n').first().toInt();

    auto autosave = autosave_of(*window_, folder_.path());
    autosave->offer_recovery();
    ASSERT_NE(autosave->dialog(), nullptr) << "killed after " << pause_ms << " ms";
    auto* list = autosave->dialog()->findChild<QListWidget*>();
    ASSERT_EQ(list->count(), 1);
    open_phantom();
    for (QPushButton* button : autosave->dialog()->findChildren<QPushButton*>())
      if (button->isDefault()) button->click();
    ASSERT_FALSE(bench().has_unsaved_changes());
    ASSERT_TRUE(wait_until([&] { return bench().has_unsaved_changes(); }))  // restored
        << window_->messages().text().toStdString();
    EXPECT_TRUE(window_->files().path().endsWith("ball.nii"));
    EXPECT_GE(static_cast<int>(scene().meshes.size()), known) << "killed after " << pause_ms << " ms";
    if (kills > 2)
      std::cout << "killed after " << pause_ms << " ms: " << acted << " meshes made, " << scene().meshes.size()
                << " restored\n";
  }
}

}  // namespace
}  // namespace simplexseg
