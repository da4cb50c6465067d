// SPDX-License-Identifier: Apache-2.0
// Start of a segmentation from a network, with a stand-in server.
#include <QComboBox>
#include <QElapsedTimer>
#include <QFile>
#include <QLabel>
#include <QLineEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QTest>
#include <algorithm>
#include <numbers>

#include "../remote/stand_in_process.h"
#include "gpu/backend.h"
#include "gui/input/key_map.h"
#include "gui/look/theme.h"
#include "gui/window/message_bar.h"
#include "gui/window/network_dialog.h"
#include "gui/workbench/task_line.h"
#include "image/rasterise.h"
#include "window_fixture.h"

namespace simplexseg {
namespace {

/// Window with the phantom and a seed of 5 mm in its sphere; segmentation servers of its own settings.
class NetworkTest : public WindowTest {
 protected:
  void SetUp() override {
    WindowTest::SetUp();
    if (IsSkipped()) return;
    if (!test::has_blosc()) GTEST_SKIP() << "install python3-blosc";
    config_ = qgetenv("XDG_CONFIG_HOME");
    qputenv("XDG_CONFIG_HOME", folder_.filePath("config").toUtf8());
    open_phantom(5);
    bench().pause();
  }
  void TearDown() override {
    WindowTest::TearDown();
    config_.isEmpty() ? qunsetenv("XDG_CONFIG_HOME") : qputenv("XDG_CONFIG_HOME", config_);
  }
  QAction& action() { return *window_->actions()[Act::NetworkStart]; }
  const MeshItem& item() { return scene().meshes.at(0); }
  NetworkDialog* open_dialog() {
    action().trigger();
    return window_->findChild<NetworkDialog*>();
  }
  template <class Widget>
  static Widget& part(const QWidget& dialog, const char* name) {
    return *dialog.findChild<Widget*>(name);
  }
  static void click(const QWidget& dialog, const char* name) {
    auto& button = part<QPushButton>(dialog, name);
    ASSERT_TRUE(button.isVisible() && button.isEnabled()) << name << ": " << button.toolTip().toStdString();
    QTest::mouseClick(&button, Qt::LeftButton);
  }
  static void enter_server(const QWidget& dialog, const std::string& url) {
    auto& line = *part<QComboBox>(dialog, "network_server").lineEdit();
    line.selectAll();
    QTest::keyClicks(&line, QString::fromStdString(url));
  }
  static QString statement(const QWidget& dialog) { return part<QLabel>(dialog, "network_statement").text(); }
  /// Dialog that is connected to a server.
  NetworkDialog* connect_to(const std::string& url) {
    NetworkDialog* dialog = open_dialog();
    if (!dialog) return nullptr;
    enter_server(*dialog, url);
    click(*dialog, "network_connect");
    const bool connected = wait_until([&] { return part<QPushButton>(*dialog, "network_send").isEnabled(); });
    return connected ? dialog : nullptr;
  }
  bool is_closed() {
    return wait_until([this] { return window_->findChild<NetworkDialog*>() == nullptr; });
  }
  void write_list(const std::string& servers) {
    std::filesystem::create_directories(network_servers_file().parent_path());
    QFile file(QString::fromStdString(network_servers_file().string()));
    ASSERT_TRUE(file.open(QIODevice::WriteOnly));
    file.write(("{\"simplexseg_networks\": 1, \"servers\": [" + servers + "]}").c_str());
  }
  /// Saves a picture of a dialog into the folder SIMPLEXSEG_PICTURES, if it is set.
  static void save_picture(QWidget& dialog, const char* name) {
    if (const char* folder = std::getenv("SIMPLEXSEG_PICTURES"))
      dialog.grab().save(QString("%1/%2.png").arg(folder, name));
  }

 private:
  QByteArray config_;
};

TEST_F(NetworkTest, TheMaskStartsTheSegmentationAndUndoRemovesIt) {
  test::StandInProcess process("nninteractive");
  NetworkDialog* dialog = connect_to(process.url());
  ASSERT_NE(dialog, nullptr);
  EXPECT_TRUE(
      statement(*dialog).contains("Will be sent to " + QString::fromStdString(process.url()) + " (nnInteractive):"));
  EXPECT_TRUE(statement(*dialog).contains("all voxels of the image")) << statement(*dialog).toStdString();
  EXPECT_TRUE(statement(*dialog).contains("and 1 point."));
  EXPECT_TRUE(statement(*dialog).contains("Will not be sent:</b> names, dates and identifiers of the patient"));
  EXPECT_TRUE(statement(*dialog).contains("CC BY-NC-SA 4.0 for tests"));
  save_picture(*dialog, "network-connected");
  click(*dialog, "network_send");
  ASSERT_TRUE(is_closed());
  ASSERT_TRUE(item().start && item().start->network);
  EXPECT_EQ(item().start->network->server, process.url());
  EXPECT_EQ(item().start->error_mm, kNetworkErrorMm);
  EXPECT_TRUE(window_->messages().text().contains("'object' starts from the mask of nnInteractive"))
      << window_->messages().text().toStdString();
  const QLabel& card = *window_->findChild<QLabel*>("card_prior");
  EXPECT_TRUE(card.isVisible() && card.text().startsWith("Network: nnInteractive")) << card.text().toStdString();
  EXPECT_TRUE(card.toolTip().contains("CC BY-NC-SA 4.0 for tests"));
  const Mask sphere = rasterise(*item().start->mesh, bench().session().volume().geometry());
  const auto voxels = static_cast<double>(std::ranges::count(sphere.voxels, 1));
  constexpr double kRadius = 0.3 * 64 + 0.5;  // of the sphere with its voxels of partial volume
  EXPECT_NEAR(voxels, 4.0 / 3 * std::numbers::pi * kRadius * kRadius * kRadius, 0.1 * voxels) << "not the seed";
  EXPECT_TRUE(std::holds_alternative<SetStart>(bench().session().log().back().command));
  process.end();  // neither undo nor redo needs the server

  bench().pause();
  window_->actions()[Act::Undo]->trigger();
  EXPECT_FALSE(item().start);
  EXPECT_FALSE(card.isVisible());
  window_->actions()[Act::Redo]->trigger();
  EXPECT_TRUE(item().start);
}

TEST_F(NetworkTest, NothingIsContactedBeforeConnectAndNoImageBeforeSend) {
  test::StandInProcess process("nninteractive");
  write_list("{\"name\": \"gpu\", \"url\": \"" + process.url() + "\", \"timeout_s\": 60}");
  NetworkDialog* dialog = open_dialog();
  ASSERT_NE(dialog, nullptr);
  EXPECT_EQ(part<QComboBox>(*dialog, "network_server").currentText(), "gpu");
  EXPECT_TRUE(statement(*dialog).contains("The image is sent only when you press Send image."))
      << statement(*dialog).toStdString();
  QTest::qWait(300);
  EXPECT_EQ(process.requests(), "");
  click(*dialog, "network_connect");
  ASSERT_TRUE(wait_until([&] { return part<QPushButton>(*dialog, "network_send").isEnabled(); }));
  EXPECT_EQ(process.requests(), "GET /healthz GET /capabilities");
  // Another address is another connection.
  QTest::keyClick(&part<QComboBox>(*dialog, "network_server"), Qt::Key_A);
  EXPECT_FALSE(part<QPushButton>(*dialog, "network_send").isEnabled());
  EXPECT_TRUE(statement(*dialog).contains("The image is sent only when you press Send image."));
  dialog->reject();
  ASSERT_TRUE(is_closed());
  EXPECT_EQ(process.requests(), "GET /healthz GET /capabilities");
  EXPECT_FALSE(item().start);
}

TEST_F(NetworkTest, EachFaultIsOneLineAndTheDialogStaysUsable) {
  const auto expect_fault = [&](NetworkDialog& dialog, const QString& words) {
    ASSERT_TRUE(wait_until([&] { return !dialog.task().busy(); }));
    EXPECT_TRUE(dialog.task().text().contains(words)) << dialog.task().text().toStdString();
    EXPECT_FALSE(dialog.task().text().contains('\n'));
    EXPECT_EQ(part<QLabel>(dialog, "task_line").property("role"), "warning");
    EXPECT_TRUE(dialog.isVisible());
    EXPECT_FALSE(item().start);
  };
  NetworkDialog* dialog = open_dialog();
  ASSERT_NE(dialog, nullptr);
  save_picture(*dialog, "network-before");
  click(*dialog, "network_connect");
  expect_fault(*dialog, "its address is missing");
  enter_server(*dialog, "other");
  click(*dialog, "network_connect");
  expect_fault(*dialog, "other");
  enter_server(*dialog, "http://127.0.0.1:9");
  click(*dialog, "network_connect");
  expect_fault(*dialog, "it refused the connection at http://127.0.0.1:9");
  save_picture(*dialog, "network-fault");
  EXPECT_FALSE(part<QPushButton>(*dialog, "network_send").isEnabled());
  {
    test::StandInProcess process("nninteractive", "", "sesame");
    enter_server(*dialog, process.url());
    click(*dialog, "network_connect");
    expect_fault(*dialog, "it requires credentials (401");
  }
  for (const auto& [fault, words] : {std::pair("500", "it failed (500"), {"empty", "it is empty"}}) {
    test::StandInProcess process("nninteractive", fault);
    enter_server(*dialog, process.url());
    click(*dialog, "network_connect");
    ASSERT_TRUE(wait_until([&] { return part<QPushButton>(*dialog, "network_send").isEnabled(); }));
    click(*dialog, "network_send");
    expect_fault(*dialog, words);
    EXPECT_TRUE(part<QPushButton>(*dialog, "network_send").isEnabled()) << "it can be sent again";
  }
}

TEST_F(NetworkTest, ADamagedListIsOneLineAndAUrlCanStillBeEntered) {
  write_list("{\"name\": \"gpu\"}");
  NetworkDialog* dialog = open_dialog();
  ASSERT_NE(dialog, nullptr);
  EXPECT_TRUE(dialog->task().text().contains("networks.json")) << dialog->task().text().toStdString();
  test::StandInProcess process("monai");
  enter_server(*dialog, process.url());
  click(*dialog, "network_connect");
  ASSERT_TRUE(wait_until([&] { return part<QPushButton>(*dialog, "network_send").isEnabled(); }));
  EXPECT_TRUE(statement(*dialog).contains("size, spacing and position")) << statement(*dialog).toStdString();
  EXPECT_TRUE(statement(*dialog).contains("not stated. Ask who runs the server."));
  auto& choice = part<QComboBox>(*dialog, "network_choice");
  ASSERT_EQ(choice.count(), 2);
  EXPECT_EQ(choice.currentText(), "clicks");
}

TEST_F(NetworkTest, ACallIsCancelledByTheButtonOrByEsc) {
  test::StandInProcess slow("nninteractive", "slow prediction");
  NetworkDialog* dialog = connect_to(slow.url());
  ASSERT_NE(dialog, nullptr);
  click(*dialog, "network_send");
  ASSERT_TRUE(wait_until([&] { return dialog->task().text().contains("1 s"); })) << dialog->task().text().toStdString();
  EXPECT_TRUE(dialog->findChild<QProgressBar*>()->isVisible());
  EXPECT_FALSE(part<QComboBox>(*dialog, "network_server").isEnabled());
  save_picture(*dialog, "network-running");
  click(*dialog, "task_cancel");
  EXPECT_FALSE(dialog->task().busy());
  EXPECT_EQ(dialog->task().text(), "Cancelled: the segmentation has not changed");
  click(*dialog, "network_send");
  ASSERT_TRUE(wait_until([&] { return dialog->task().text().contains("1 s"); }));
  QTest::keyClick(dialog, Qt::Key_Escape);
  EXPECT_FALSE(dialog->task().busy());
  EXPECT_TRUE(dialog->isVisible());
  QTest::keyClick(dialog, Qt::Key_Escape);
  ASSERT_TRUE(is_closed());
  EXPECT_FALSE(item().start);
}

TEST_F(NetworkTest, ClosingTheProgramCancelsACall) {
  test::StandInProcess slow("nninteractive", "slow");
  NetworkDialog* dialog = connect_to(slow.url());
  ASSERT_NE(dialog, nullptr);
  click(*dialog, "network_send");
  ASSERT_TRUE(wait_until([&] { return dialog->task().text().contains("1 s"); }));
  QElapsedTimer timer;
  timer.start();
  window_.reset();
  EXPECT_LT(timer.elapsed(), 3000);
}

TEST_F(NetworkTest, IsDisabledWithAReason) {
  EXPECT_TRUE(action().isEnabled());
  EditMesh lock{};
  lock.mesh = item().id, lock.locked = true;
  bench().apply(lock);
  EXPECT_FALSE(action().isEnabled());
  EXPECT_EQ(action().toolTip(), why_locked());
  bench().apply(Undo{});
  EXPECT_TRUE(action().isEnabled());
  bench().apply(DeleteMesh{item().id});
  EXPECT_FALSE(action().isEnabled());
  EXPECT_TRUE(action().toolTip().contains("place a seed first")) << action().toolTip().toStdString();
  show_window(make_cpu_engine(1), {});
  EXPECT_EQ(action().toolTip(), "Open a volume first");
}

TEST_F(NetworkTest, TheDialogFitsASmallWindowAndEveryControlHasAName) {
  window_->resize(800, 600);
  QApplication::processEvents();
  test::StandInProcess process("nninteractive");
  for (const bool dark : {true, false}) {
    theme::apply(*qApp, dark);
    NetworkDialog* dialog = connect_to(process.url());
    ASSERT_NE(dialog, nullptr);
    QTest::keyClick(dialog->findChild<QComboBox*>("network_server"), Qt::Key_End);
    for (QComboBox* choice : dialog->findChildren<QComboBox*>())
      if (choice->accessibleName() == "Credentials") choice->setCurrentIndex(2);
    QApplication::processEvents();
    EXPECT_LE(dialog->width(), 800);
    EXPECT_LE(dialog->height(), 600);
    EXPECT_GE(check_controls(*dialog), 9);
    dialog->reject();
    ASSERT_TRUE(is_closed());
  }
  theme::apply(*qApp, true);
}

TEST_F(NetworkTest, AStartIsMadeByKeyboardAlone) {
  test::StandInProcess process("nninteractive");
  ASSERT_TRUE(has_keys());
  const auto key = [](int code, Qt::KeyboardModifiers modifiers = {}) {
    QTest::keyClick(QApplication::activeWindow()->windowHandle(), static_cast<Qt::Key>(code), modifiers);
  };
  key(Qt::Key_N, Qt::ControlModifier);
  auto* dialog = window_->findChild<NetworkDialog*>();
  ASSERT_TRUE(dialog && QTest::qWaitForWindowActive(dialog));
  for (const auto& [letter, name] : {std::pair{Qt::Key_R, "Certificates"},
                                     {Qt::Key_D, "Credentials"},
                                     {Qt::Key_T, "Time-out"},
                                     {Qt::Key_E, "Expected error"},
                                     {Qt::Key_S, "Server"}}) {
    key(letter, Qt::AltModifier);
    ASSERT_NE(dialog->focusWidget(), nullptr);
    EXPECT_EQ(dialog->focusWidget()->accessibleName(), name);
  }
  for (const char letter : process.url()) QTest::keyClick(dialog->windowHandle(), letter);
  key(Qt::Key_Return);
  ASSERT_TRUE(wait_until([&] { return part<QPushButton>(*dialog, "network_send").isEnabled(); }));
  key(Qt::Key_Return);  // connects again: Return alone does not send the image
  ASSERT_TRUE(wait_until([&] { return !dialog->task().busy(); }));
  EXPECT_TRUE(dialog->isVisible());
  EXPECT_FALSE(item().start);
  key(Qt::Key_E, Qt::AltModifier);
  key(Qt::Key_A, Qt::ControlModifier);
  for (const char letter : {'3', '.', '5'}) QTest::keyClick(dialog->windowHandle(), letter);
  key(Qt::Key_I, Qt::AltModifier);
  ASSERT_TRUE(is_closed());
  ASSERT_TRUE(item().start);
  EXPECT_EQ(item().start->error_mm, 3.5);
}

}  // namespace
}  // namespace simplexseg
