// SPDX-License-Identifier: Apache-2.0
// Work that is kept: after each action, by another thread, until it is saved; and offered after a crash. A scripted
// session is killed at random moments: SIMPLEXSEG_KILLS says how often, two times unless told otherwise.
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
#include "io/recovery.h"
#include "io/scene_io.h"
#include "io/volume_io.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

constexpr const char* kScript = "SIMPLEXSEG_SCRIPTED_SESSION";

std::unique_ptr<Autosave> autosave_of(MainWindow& window, const QString& folder) {
  return std::make_unique<Autosave>(window.workbench(), window.files(), window.job(), window,
                                    (folder + "/work").toStdString());
}

/// The session that is killed: opens ball.nii of its folder, adds meshes and points by the mouse without end, and says
/// each time that work was kept how many there are.
void run_scripted_session(const QString& folder) {
  if (!why_no_window().empty()) return;
  MainWindow window(make_cpu_engine(1));
  window.set_unattended();
  window.resize(900, 700);
  window.show();
  const auto autosave = autosave_of(window, folder);
  const std::string volume = (folder + "/ball.nii").toStdString();
  window.files().take(load_input(volume), volume);
  std::map<std::uint64_t, std::size_t> meshes{{0, 0}};  // since which revision there are so many
  QObject::connect(&window.workbench(), &Workbench::acted, [&] {
    meshes.emplace(window.workbench().session().revision(), window.workbench().scene().meshes.size());
  });
  QObject::connect(autosave.get(), &Autosave::kept, [&](quint64 revision) {
    const std::vector<LostWork> none = find_lost_work((folder + "/work").toStdString());
    std::cout << "kept " << std::prev(meshes.upper_bound(revision))->second << std::endl;
    if (!none.empty()) std::cout << "taken from a session that lives" << std::endl;
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

class KeptWorkTest : public PausedPhantomTest {
 protected:
  void SetUp() override {
    PausedPhantomTest::SetUp();
    if (IsSkipped()) return;
    write_volume(folder_.filePath("ball.nii").toStdString(), make_phantom("sphere", {}).image);
  }
  std::filesystem::path root() const { return folder_.filePath("work").toStdString(); }
  void open_ball() {
    const std::string path = folder_.filePath("ball.nii").toStdString();
    window_->files().take(load_input(path), path);
  }
  ItemId add_mesh() {
    ItemId mesh = 0;
    bench().pause();
    bench().apply(AddMesh{"", Seed{bench().view.crosshair_mm, 6}, {}, 0}, &mesh);
    return mesh;
  }
  /// Takes a copy of what is kept at this moment, as a session that is killed leaves it.
  void leave_as_if_killed() {
    for (const auto& entry : std::filesystem::directory_iterator(root()))
      if (std::filesystem::exists(entry.path() / "work.json"))
        std::filesystem::copy(entry.path(), root() / "window-killed", std::filesystem::copy_options::recursive);
  }
  bool is_kept() const {
    for (const auto& entry : std::filesystem::directory_iterator(root()))
      if (std::filesystem::exists(entry.path() / "work.json")) return true;
    return false;
  }
};

TEST_F(KeptWorkTest, WorkIsKeptAfterEachActionUntilItIsSaved) {
  EXPECT_LE(Autosave::kEveryMs, 60'000);
  auto autosave = autosave_of(*window_, folder_.path());
  open_ball();
  QSignalSpy kept(autosave.get(), &Autosave::kept);
  EXPECT_FALSE(is_kept());
  const ItemId mesh = add_mesh();
  for (int n = 0; n < 5; ++n) bench().apply(MovePoint{mesh, {0, 0, 0}, true});  // refused: no action
  ASSERT_TRUE(wait_until([&] { return kept.count() == 1; })) << "by itself";
  EXPECT_TRUE(is_kept());
  autosave->keep_now();
  for (int n = 0; n < 20; ++n) QApplication::processEvents();
  EXPECT_EQ(kept.count(), 1) << "nothing has changed";
  bench().advance_steps(3);
  autosave->keep_now();  // as every minute
  ASSERT_TRUE(wait_until([&] { return kept.count() == 2; }));
  ASSERT_TRUE(window_->files().save_scene_to(folder_.filePath("mine.json")));
  ASSERT_TRUE(wait_until([&] { return !is_kept(); })) << "saved: nothing is to be offered";
  add_mesh();
  ASSERT_TRUE(wait_until([&] { return is_kept(); }));
  autosave.reset();
  EXPECT_TRUE(std::filesystem::is_empty(root())) << "the program has ended as it should";
}

TEST_F(KeptWorkTest, LostWorkIsOfferedAndGoesOnUnsaved) {
  auto autosave = autosave_of(*window_, folder_.path());
  open_ball();
  add_mesh();
  ASSERT_TRUE(window_->files().save_scene_to(folder_.filePath("mine.json")));
  const ItemId mesh = add_mesh();
  bench().apply(AddPoint{mesh, bench().view.crosshair_mm + Eigen::Vector3d(0, 0, 3)});
  bench().advance_steps(4);
  bench().view.window = 321, bench().view.level = 123;
  autosave->keep_now();
  ASSERT_TRUE(wait_until([&] { return is_kept(); }));
  const std::vector<Eigen::Vector3f> pose = scene().meshes[1].mesh.positions;
  const std::vector<std::string> done = bench().session().history().undo_names();
  leave_as_if_killed();
  autosave.reset();
  open_phantom();
  autosave = autosave_of(*window_, folder_.path());
  autosave->offer();
  ASSERT_NE(autosave->question(), nullptr);
  auto* list = autosave->question()->findChild<QListWidget*>();
  ASSERT_EQ(list->count(), 1);
  const QString line = list->item(0)->text();
  for (const char* part : {"mine.json", "2 meshes", "1 point", "ago"}) EXPECT_TRUE(line.contains(part)) << part;
  QPushButton* take = nullptr;
  for (QPushButton* button : autosave->question()->findChildren<QPushButton*>()) {
    EXPECT_TRUE(button->text().contains('&')) << button->text().toStdString();
    if (button->isDefault()) take = button;
  }
  ASSERT_NE(take, nullptr);
  QKeyEvent enter(QEvent::KeyPress, Qt::Key_Return, Qt::NoModifier);
  QApplication::sendEvent(take, &enter);
  ASSERT_TRUE(wait_until([&] { return scene().meshes.size() == 2; }));
  EXPECT_EQ(scene().meshes[1].mesh.positions, pose);
  EXPECT_EQ(scene().points.size(), 1u);
  EXPECT_EQ(bench().session().history().undo_names(), done) << "it can be taken back";
  EXPECT_EQ(bench().view.window, 321);
  EXPECT_EQ(bench().view.level, 123);
  EXPECT_TRUE(bench().has_unsaved_changes());
  EXPECT_EQ(window_->files().scene_path(), folder_.filePath("mine.json")) << "Ctrl+S goes to the user's own file";
  ASSERT_TRUE(wait_until([&] { return !std::filesystem::exists(root() / "window-killed"); }));
  EXPECT_TRUE(is_kept()) << "by this window now";
}

TEST_F(KeptWorkTest, DiscardedWorkIsGoneAndAnotherWindowTakesNone) {
  auto autosave = autosave_of(*window_, folder_.path());
  open_ball();
  add_mesh();
  autosave->keep_now();
  ASSERT_TRUE(wait_until([&] { return is_kept(); }));
  MainWindow other(make_cpu_engine(1));
  auto others = autosave_of(other, folder_.path());
  others->offer();
  EXPECT_EQ(others->question(), nullptr) << "its window lives";
  leave_as_if_killed();
  others->offer();
  ASSERT_NE(others->question(), nullptr);
  autosave->offer();
  EXPECT_EQ(autosave->question(), nullptr) << "the other window has it";
  for (QPushButton* button : others->question()->findChildren<QPushButton*>())
    if (button->text().contains("Discard")) button->click();
  EXPECT_FALSE(std::filesystem::exists(root() / "window-killed"));
}

TEST_F(KeptWorkTest, LeavingAsksWithAKeyForEachAnswer) {
  open_ball();
  add_mesh();
  QStringList texts;
  const auto answer_with = [&](const QString& wanted) {
    QTimer::singleShot(0, [&texts, wanted] {
      auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
      ASSERT_NE(box, nullptr);
      for (QAbstractButton* button : box->buttons()) {
        texts << button->text();
        if (button->text() == wanted) QTimer::singleShot(0, button, &QAbstractButton::click);
      }
    });
    return window_->files().may_discard();
  };
  EXPECT_FALSE(answer_with("&Cancel"));
  EXPECT_TRUE(answer_with("&Discard"));
  for (const char* text : {"&Save", "&Discard", "&Cancel"}) EXPECT_TRUE(texts.contains(text)) << text;
}

TEST_F(KeptWorkTest, AKilledSessionIsOfferedWhole) {
  const int kills =
      qEnvironmentVariableIntValue("SIMPLEXSEG_KILLS") > 0 ? qEnvironmentVariableIntValue("SIMPLEXSEG_KILLS") : 2;
  std::mt19937 random(std::random_device{}());
  for (int n = 0; n < kills; ++n) {
    std::filesystem::remove_all(root());
    QProcess session;
    QProcessEnvironment variables = QProcessEnvironment::systemEnvironment();
    variables.insert(kScript, folder_.path());
    session.setProcessEnvironment(variables);
    session.start(QCoreApplication::applicationFilePath(), {"--gtest_filter=Bindings.HelpListsEveryRow"});
    QByteArray said;
    ASSERT_TRUE(wait_until([&] {
      said += session.readAllStandardOutput();
      return said.contains("kept");
    })) << said.toStdString();
    // Anywhere in the next action or its keeping.
    const int pause_ms = static_cast<int>(random() % (kills > 2 ? 4000 : 700));
    QElapsedTimer timer;
    timer.start();
    while (timer.elapsed() < pause_ms) {
      QApplication::processEvents(QEventLoop::AllEvents | QEventLoop::WaitForMoreEvents, 5);
      said += session.readAllStandardOutput();
    }
    ::kill(static_cast<pid_t>(session.processId()), SIGKILL);
    session.waitForFinished();
    ASSERT_EQ(session.exitStatus(), QProcess::CrashExit);
    EXPECT_FALSE(said.contains("taken from")) << said.toStdString();
    const int known = said.mid(said.lastIndexOf("kept ") + 5).split('\n').first().toInt();
    said += session.readAllStandardOutput();
    const int acted = said.mid(said.lastIndexOf("acted ") + 6).split('\n').first().toInt();

    auto autosave = autosave_of(*window_, folder_.path());
    autosave->offer();
    ASSERT_NE(autosave->question(), nullptr) << "killed after " << pause_ms << " ms";
    auto* list = autosave->question()->findChild<QListWidget*>();
    ASSERT_EQ(list->count(), 1);
    open_phantom();
    for (QPushButton* button : autosave->question()->findChildren<QPushButton*>())
      if (button->isDefault()) button->click();
    ASSERT_FALSE(bench().has_unsaved_changes());
    ASSERT_TRUE(wait_until([&] { return bench().has_unsaved_changes(); }))  // it is back
        << window_->messages().text().toStdString();
    EXPECT_TRUE(window_->files().path().endsWith("ball.nii"));
    EXPECT_GE(static_cast<int>(scene().meshes.size()), known) << "killed after " << pause_ms << " ms";
    if (kills > 2)
      std::cout << "killed after " << pause_ms << " ms: " << acted << " meshes made, " << scene().meshes.size()
                << " came back\n";
  }
}

}  // namespace
}  // namespace simplexseg
