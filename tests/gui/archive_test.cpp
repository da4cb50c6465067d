// SPDX-License-Identifier: Apache-2.0
// Dialogs for archives, with a fake archive: servers, search, fetch, errors.
#include <QComboBox>
#include <QFile>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QProgressBar>
#include <QSpinBox>
#include <QTimer>

#include "archive_fixture.h"
#include "gui/look/theme.h"
#include "gui/window/archive/archive_server_dialog.h"
#include "gui/window/file_actions.h"
#include "gui/window/message_bar.h"

namespace simplexseg {
namespace {

class ArchiveTest : public ArchiveFixture {
 protected:
  static QLineEdit& field(const QWidget& dialog, const QString& name) {
    for (QLineEdit* line : dialog.findChildren<QLineEdit*>())
      if (line->accessibleName() == name) return *line;
    throw std::runtime_error("no field " + name.toStdString());
  }
  static QByteArray servers_file() {
    QFile file(QString::fromStdString(archive_servers_file().string()));
    return file.open(QIODevice::ReadOnly) ? file.readAll() : QByteArray();
  }
  static QString refusal(const QWidget& dialog) { return dialog.findChild<QLabel*>("archive_refusal")->text(); }
  static void save(QWidget& dialog) {
    for (QPushButton* button : dialog.findChildren<QPushButton*>())
      if (button->text().contains("Save")) QTest::mouseClick(button, Qt::LeftButton);
  }
  /// Clicks the button with this text in the question that opens next.
  static void click_in_question(const QString& text) {
    QTimer::singleShot(50, qApp, [text] {
      auto* question = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
      ASSERT_NE(question, nullptr);
      for (QAbstractButton* button : question->buttons())
        if (button->text() == text) return QTest::mouseClick(button, Qt::LeftButton);
      question->reject();
    });
  }
};

TEST_F(ArchiveTest, ArchivesAreAddedEditedAndRemoved) {
  ArchiveDialog* dialog = find_dialog();
  ASSERT_NE(dialog, nullptr);
  EXPECT_FALSE(dialog->findChild<QPushButton*>("archive_search")->isEnabled());
  EXPECT_EQ(dialog->findChild<QPushButton*>("archive_search")->toolTip(), "Add an archive first");
  click(*dialog, "archive_add");
  auto* entry = dialog->findChild<ArchiveServerDialog*>();
  ASSERT_TRUE(entry && entry->isVisible());
  type(field(*entry, "Name"), "hospital");
  type(field(*entry, "Address"), "https://pacs.example/dicom-web/");
  QTest::keyClick(&field(*entry, "Address"), Qt::Key_Return);
  ASSERT_TRUE(wait_until([&] { return dialog->findChild<ArchiveServerDialog*>() == nullptr; }));
  ASSERT_EQ(read_archive_servers().size(), 1u);
  EXPECT_EQ(read_archive_servers()[0].url, "https://pacs.example/dicom-web");
  EXPECT_TRUE(dialog->findChild<QPushButton*>("archive_search")->isEnabled());

  click(*dialog, "archive_edit");
  entry = dialog->findChild<ArchiveServerDialog*>();
  EXPECT_EQ(field(*entry, "Name").text(), "hospital");
  for (QComboBox* choice : entry->findChildren<QComboBox*>())
    if (choice->accessibleName() == "Protocol") QTest::keyClick(choice, Qt::Key_Down);
  type(field(*entry, "Host"), "pacs.example");
  type(field(*entry, "AE title of the archive"), "PACS");
  save(*entry);
  ASSERT_TRUE(wait_until([&] { return dialog->findChild<ArchiveServerDialog*>() == nullptr; }));
  EXPECT_EQ(address_of(read_archive_servers().at(0)), "PACS@pacs.example:104");

  click_in_question("&Cancel");
  click(*dialog, "archive_remove");
  EXPECT_EQ(read_archive_servers().size(), 1u);
  click_in_question("&Remove");
  click(*dialog, "archive_remove");
  EXPECT_TRUE(read_archive_servers().empty());
  EXPECT_FALSE(dialog->findChild<QPushButton*>("archive_remove")->isEnabled());
}

TEST_F(ArchiveTest, InvalidArchivesAreRefusedAndNoSecretIsStored) {
  write_two_servers();
  const QByteArray before = servers_file();
  ArchiveDialog* dialog = find_dialog();
  click(*dialog, "archive_add");
  auto* entry = dialog->findChild<ArchiveServerDialog*>();
  type(field(*entry, "Name"), "one");
  type(field(*entry, "Address"), "https://pacs.example/dicom-web");
  save(*entry);
  EXPECT_TRUE(refusal(*entry).contains("two have the name one")) << refusal(*entry).toStdString();
  type(field(*entry, "Name"), "three");
  for (QComboBox* choice : entry->findChildren<QComboBox*>())
    if (choice->accessibleName() == "Credentials") QTest::keyClick(choice, Qt::Key_Down);
  save(*entry);
  EXPECT_TRUE(refusal(*entry).contains("enter one, or select \"none\"")) << refusal(*entry).toStdString();
  type(field(*entry, "Variable with credentials"), "jane:hunter2");
  save(*entry);
  EXPECT_TRUE(refusal(*entry).contains("not the name of an environment variable")) << refusal(*entry).toStdString();
  EXPECT_FALSE(refusal(*entry).contains("hunter2"));
  type(field(*entry, "Variable with credentials"), "PACS_LOGIN");
  type(field(*entry, "Address"), "http://pacs.example/dicom-web");
  save(*entry);
  EXPECT_TRUE(refusal(*entry).contains("use https")) << refusal(*entry).toStdString();
  EXPECT_TRUE(entry->isVisible());
  EXPECT_EQ(servers_file(), before);
  type(field(*entry, "Address"), "https://pacs.example/dicom-web");
  save(*entry);
  EXPECT_EQ(read_archive_servers().back().credentials_variable, "PACS_LOGIN");
}

TEST_F(ArchiveTest, DimseNeedsNoCredentials) {
  ArchiveServer web;
  web.name = "one", web.url = "https://host/dicom-web", web.credentials_variable = "LOGIN";
  std::optional<ArchiveServer> saved;
  ArchiveServerDialog dialog(
      web, [&](const ArchiveServer& server) { saved = server; }, window_.get());
  dialog.show();
  type(field(dialog, "Variable with credentials"), "");
  auto* protocol = dialog.findChild<QComboBox*>();
  ASSERT_EQ(protocol->count(), 2);
  protocol->setCurrentIndex(1);
  type(field(dialog, "Host"), "pacs");
  type(field(dialog, "AE title of the archive"), "PACS");
  save(dialog);
  ASSERT_TRUE(saved) << dialog.findChild<QLabel*>("archive_refusal")->text().toStdString();
  EXPECT_EQ(saved->host, "pacs");
}

TEST_F(ArchiveTest, ADamagedListOfArchivesIsReportedAndLeftUnchanged) {
  write_two_servers();
  QFile file(QString::fromStdString(archive_servers_file().string()));
  ASSERT_TRUE(file.open(QIODevice::WriteOnly));
  file.write("{\"servers\": [");
  file.close();
  ArchiveDialog* dialog = find_dialog();
  EXPECT_TRUE(dialog->task().text().contains("archives.json")) << dialog->task().text().toStdString();
  EXPECT_FALSE(dialog->findChild<QPushButton*>("archive_add")->isEnabled());
  EXPECT_EQ(servers_file(), "{\"servers\": [");
  write_two_servers();
  EXPECT_EQ(find_dialog(), dialog);  // opened again: the file is read again
  EXPECT_TRUE(dialog->findChild<QPushButton*>("archive_add")->isEnabled());
  EXPECT_TRUE(dialog->task().text().isEmpty()) << dialog->task().text().toStdString();
}

TEST_F(ArchiveTest, StudiesAndSeriesAreListedWithTheirCounts) {
  write_two_servers();
  ArchiveDialog* dialog = find_dialog();
  ASSERT_NE(dialog, nullptr);
  type(field(*dialog, "Patient name"), "do*");
  type(field(*dialog, "Patient ID"), "P-17");
  type(field(*dialog, "Description"), "follow");
  type(field(*dialog, "From"), "2024-01-01");
  auto* modality = dialog->findChildren<QComboBox*>().last();
  for (QComboBox* choice : dialog->findChildren<QComboBox*>())
    if (choice->accessibleName() == "Modality") modality = choice;
  QTest::keyClicks(modality->lineEdit(), "CT");
  QTest::keyClick(&field(*dialog, "Description"), Qt::Key_Return);
  QTreeWidget& tree = results(*dialog);
  ASSERT_TRUE(wait_until([&] { return tree.topLevelItemCount() == 2; }));
  EXPECT_EQ(fake_.server, "one");
  EXPECT_EQ(fake_.last_query.patient_name, "do*");
  EXPECT_EQ(fake_.last_query.patient_id, "P-17");
  EXPECT_EQ(fake_.last_query.description, "follow");
  EXPECT_EQ(fake_.last_query.date, "2024-01-01..");
  EXPECT_EQ(fake_.last_query.modality, "CT");
  EXPECT_EQ(dialog->task().text(), "2 studies");
  const auto row = [](const QTreeWidgetItem& item) {
    QStringList texts;
    for (int column = 0; column < item.columnCount(); ++column) texts << item.text(column);
    return texts.join('|').toStdString();
  };
  EXPECT_EQ(row(*tree.topLevelItem(0)), "Doe, Jane|P-17|2024-05-31|CT SEG|follow-up|2|11");
  EXPECT_EQ(row(*tree.topLevelItem(1)), "Roe, Richard|P-18|2023-01-02|MR|head|?|?");

  QTest::keyClick(&tree, Qt::Key_Right);
  ASSERT_TRUE(wait_until([&] { return tree.topLevelItem(0)->childCount() == 2; }));
  EXPECT_EQ(row(*tree.topLevelItem(0)->child(0)), "Series 3|||CT|chest||10");
  EXPECT_EQ(row(*tree.topLevelItem(0)->child(1)), "Series 4|||SEG|lungs||1");
  EXPECT_EQ(tree.currentItem(), tree.topLevelItem(0)->child(0)) << "the one with the most images";

  // An invalid date is refused by the dialog.
  type(field(*dialog, "From"), "31.1.2024");
  QTest::keyClick(&field(*dialog, "From"), Qt::Key_Return);
  EXPECT_FALSE(dialog->task().busy());
  EXPECT_TRUE(dialog->task().text().contains("31.1.2024")) << dialog->task().text().toStdString();
  // Another archive has other studies.
  QTest::keyClick(dialog->findChild<QComboBox*>("archive_server"), Qt::Key_Down);
  EXPECT_EQ(tree.topLevelItemCount(), 0);
}

TEST_F(ArchiveTest, AFetchedSeriesOpensLikeAFolder) {
  write_two_servers();
  ArchiveDialog* dialog = select_first_series();
  ASSERT_NE(dialog, nullptr);
  QTest::keyClick(&results(*dialog), Qt::Key_Return);
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  EXPECT_EQ(bench().session().volume().geometry().size, (std::array<int, 3>{24, 20, 10}));
  EXPECT_EQ(bench().patient_name(), "Doe, Jane");
  EXPECT_FALSE(dialog->isVisible());
  EXPECT_EQ(cached().size(), 2u);  // folders of the server and of the series
  // The path in the cache is not shown to users, and no files are saved there.
  EXPECT_EQ(window_->files().scene_name(), "chest");
  EXPECT_TRUE(window_->files().suggested_path("-labels", ".nii.gz").endsWith("/chest-labels.nii.gz"));
  EXPECT_FALSE(window_->files().suggested_path("", ".png").contains("simplexseg/archive"));
  // The results are still listed.
  EXPECT_EQ(find_dialog(), dialog);
  EXPECT_EQ(results(*dialog).topLevelItemCount(), 2);
}

TEST_F(ArchiveTest, AFetchShowsItsProgressAndCanBeCancelled) {
  write_two_servers();
  open_phantom();
  bench().pause();
  ArchiveDialog* dialog = select_first_series();
  ASSERT_NE(dialog, nullptr);
  const ItemId before = scene().meshes[0].id;
  fake_.blocked = true;
  click(*dialog, "archive_fetch");
  auto* bar = dialog->findChild<QProgressBar*>();
  ASSERT_TRUE(wait_until([&] { return bar->isVisible() && bar->maximum() == 12 && bar->value() == 3; }));
  EXPECT_EQ(dialog->task().text(), "Fetching: 3 of 12, 6.2 MB");
  EXPECT_FALSE(dialog->findChild<QPushButton*>("archive_search")->isEnabled());
  EXPECT_EQ(cached().size(), 1u) << "incoming";
  // The window stays usable meanwhile.
  const double slice = bench().view.crosshair_mm.z();
  QTest::keyClick(&axial(), Qt::Key_PageUp);
  EXPECT_NE(bench().view.crosshair_mm.z(), slice);

  click(*dialog, "task_cancel");
  EXPECT_EQ(dialog->task().text(), "Cancelled: no image was stored");
  EXPECT_FALSE(bar->isVisible());
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 0 && cached().empty(); }));
  EXPECT_EQ(scene().meshes[0].id, before);
  // Esc also cancels; a second Esc closes the dialog.
  click(*dialog, "archive_fetch");
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 1; }));
  QTest::keyClick(dialog, Qt::Key_Escape);
  EXPECT_FALSE(dialog->task().busy());
  EXPECT_TRUE(dialog->isVisible());
  QTest::keyClick(dialog, Qt::Key_Escape);
  EXPECT_FALSE(dialog->isVisible());
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 0 && cached().empty(); }));
  EXPECT_TRUE(bench().has_volume());
  EXPECT_EQ(scene().meshes[0].id, before);
}

TEST_F(ArchiveTest, ClosingTheProgramCancelsAFetch) {
  write_two_servers();
  ArchiveDialog* dialog = select_first_series();
  ASSERT_NE(dialog, nullptr);
  fake_.blocked = true;
  click(*dialog, "archive_fetch");
  ASSERT_TRUE(wait_until([&] { return fake_.waiting == 1; }));
  window_.reset();
  EXPECT_EQ(fake_.waiting, 0);
  EXPECT_TRUE(cached().empty());
}

TEST_F(ArchiveTest, EachFaultIsOneLineAndTheDialogStaysUsable) {
  write_two_servers();
  const char* faults[] = {
      "the archive one: it refused the connection at http://127.0.0.1:9/dicom-web; check its host and port, and that "
      "it is running",
      "the archive one: its certificate is not trusted; name the file of its certificates",
      "the archive one: time-out: no data for 30 s; try again, or set a longer time-out",
      "the archive one: the credentials were refused (401); check the variable or the file",
      "cannot store series in \"/cache\": No space left on device; free some space"};
  ArchiveDialog* dialog = select_first_series();
  ASSERT_NE(dialog, nullptr);
  for (const char* fault : faults) {
    for (const char* button : {"archive_fetch", "archive_test", "archive_search"}) {
      SCOPED_TRACE(std::string(button) + ", " + fault);
      fake_.fault = fault;
      click(*dialog, button);
      ASSERT_TRUE(wait_until([&] { return !dialog->task().busy(); }));
      EXPECT_EQ(dialog->task().text(), QString(fault));
      EXPECT_EQ(dialog->findChild<QLabel*>("task_line")->property("role"), "warning");
      EXPECT_TRUE(cached().empty());
      EXPECT_FALSE(bench().has_volume());
    }
  }
  EXPECT_EQ(results(*dialog).topLevelItemCount(), 2) << "earlier results stay";
  // A study whose series cannot be listed is collapsed again, and can be expanded later.
  QTreeWidgetItem* second = results(*dialog).topLevelItem(1);
  second->setExpanded(true);
  ASSERT_TRUE(wait_until([&] { return !second->isExpanded(); }));
  EXPECT_EQ(dialog->task().text(), QString(faults[4]));
  fake_.fault.clear();
  fake_.series.push_back({"1.2.4", "1.2.4.1", 1, "MR", "t1", 90});
  second->setExpanded(true);
  EXPECT_TRUE(wait_until([&] { return second->childCount() == 1; }));
  EXPECT_TRUE(second->isExpanded());
  click(*dialog, "archive_test");
  EXPECT_TRUE(wait_until([&] { return dialog->task().text() == "one responds"; }));
}

TEST_F(ArchiveTest, BothDialogsFitASmallWindowInBothThemesAndEveryControlHasAName) {
  write_two_servers();
  open_dicom_with_mesh();
  window_->resize(800, 600);
  QApplication::processEvents();
  for (const bool dark : {true, false}) {
    theme::apply(*qApp, dark);
    ArchiveDialog* find = select_first_series();
    ASSERT_NE(find, nullptr);
    click(*find, "archive_edit");
    auto* entry = find->findChild<ArchiveServerDialog*>();
    SendDialog* send = send_dialog();
    ASSERT_NE(send, nullptr);
    for (QDialog* dialog : {static_cast<QDialog*>(find), static_cast<QDialog*>(entry), static_cast<QDialog*>(send)}) {
      SCOPED_TRACE(dialog->objectName().toStdString());
      QApplication::processEvents();
      EXPECT_LE(dialog->width(), 800);
      EXPECT_LE(dialog->height(), 600);
      EXPECT_EQ(dialog->grab().toImage().pixelColor(3, 3), theme::shades().window);
      EXPECT_GE(check_controls(*dialog), 5);
    }
    send->reject();
    entry->reject();
    find->reject();
    QApplication::processEvents();
  }
  theme::apply(*qApp, true);
}

TEST_F(ArchiveTest, ASeriesIsFoundFetchedAndSentByKeyboardAlone) {
  write_two_servers();
  ASSERT_TRUE(has_keys());
  const auto key = [](int code, Qt::KeyboardModifiers modifiers = {}) {
    QTest::keyClick(QApplication::activeWindow()->windowHandle(), static_cast<Qt::Key>(code), modifiers);
  };
  const auto has = [](QWidget* window) { return window && QTest::qWaitForWindowActive(window); };
  key(Qt::Key_A, Qt::ControlModifier | Qt::ShiftModifier);
  auto* find = window_->findChild<ArchiveDialog*>();
  ASSERT_TRUE(has(find));
  for (const auto& [letter, name] : {std::pair{Qt::Key_I, "Patient ID"},
                                     {Qt::Key_D, "Description"},
                                     {Qt::Key_O, "From"},
                                     {Qt::Key_U, "Until"},
                                     {Qt::Key_N, "Patient name"}}) {
    key(letter, Qt::AltModifier);
    ASSERT_NE(find->focusWidget(), nullptr);
    EXPECT_EQ(find->focusWidget()->accessibleName(), name);
  }
  for (const char letter : {'d', 'o', 'e'}) QTest::keyClick(find->windowHandle(), letter);
  key(Qt::Key_Return);
  QTreeWidget& tree = results(*find);
  ASSERT_TRUE(wait_until([&] { return tree.topLevelItemCount() == 2; }));
  EXPECT_EQ(fake_.last_query.patient_name, "doe");
  EXPECT_EQ(find->focusWidget(), &tree);
  key(Qt::Key_Return);
  ASSERT_TRUE(wait_until([&] { return tree.topLevelItem(0)->childCount() == 2; }));
  key(Qt::Key_Return);
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  bench().apply(AddMesh{"ball", Seed{bench().session().volume().geometry().centre_mm(), 4}, {}, 0});
  bench().pause();
  ASSERT_TRUE(has_keys());
  key(Qt::Key_B, Qt::ControlModifier | Qt::ShiftModifier);
  auto* send = window_->findChild<SendDialog*>();
  ASSERT_TRUE(has(send));
  key(Qt::Key_P, Qt::AltModifier);  // without the picture
  key(Qt::Key_S, Qt::AltModifier);
  ASSERT_TRUE(wait_until([&] { return fake_.sent.size() == 2; }));
  ASSERT_TRUE(wait_until([this] { return window_->findChild<SendDialog*>() == nullptr; }));
  ASSERT_TRUE(has_keys());
}

}  // namespace
}  // namespace simplexseg
