// SPDX-License-Identifier: Apache-2.0
#include "archive_fixture.h"

#include <QComboBox>
#include <QLineEdit>
#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "../io/dicom_slices.h"
#include "gui/window/file_actions.h"
#include "io/platform/load_progress.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

test::CtSlice slice_of_study() {
  return {.series = FakeArchive::kSeries, .columns = 24, .rows = 20, .study = FakeArchive::kStudy};
}

class Connection : public Archive {
 public:
  Connection(FakeArchive& fake, ArchiveServer server) : fake_(fake), server_(std::move(server)) {
    fake_.server = server_.name;
  }
  void check(const ArchiveProgress& progress) override { work(progress); }
  FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress) override {
    fake_.last_query = query;
    work(progress);
    return {fake_.studies, static_cast<int>(fake_.studies.size()) >= query.max_studies};
  }
  std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress) override {
    work(progress);
    std::vector<ArchiveSeries> found;
    for (const ArchiveSeries& one : fake_.series)
      if (one.study == study) found.push_back(one);
    return found;
  }
  fs::path fetch(const std::string&, const std::string& series, const ArchiveCache& cache,
                 const ArchiveProgress& progress) override {
    IncomingSeries incoming(cache, cache.folder_of(server_, series));
    test::write_series(incoming.folder(), slice_of_study(), 10);
    work(progress);
    return incoming.commit();
  }
  ArchiveSent send(const std::vector<fs::path>& files, const ArchiveProgress& progress) override {
    fake_.sent.clear();
    fake_.sent_bytes.clear();
    for (const fs::path& file : files) {
      fake_.sent.push_back(read_dicom_identity(file));
      std::ifstream stream(file, std::ios::binary);
      fake_.sent_bytes.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    }
    work(progress);
    return {static_cast<int>(files.size()), fake_.warnings};
  }

 private:
  void work(const ArchiveProgress& progress) {
    ++fake_.waiting;
    while (fake_.blocked) {
      if (!progress({3, 12, 6'200'000})) {
        --fake_.waiting;
        throw Cancelled();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    --fake_.waiting;
    if (!fake_.fault.empty()) throw ArchiveFault(fake_.fault);
  }

  FakeArchive& fake_;
  const ArchiveServer server_;
};

}  // namespace

FakeArchive::FakeArchive() {
  studies = {{kStudy, "Doe, Jane", "P-17", "2024-05-31", "follow-up", {"CT", "SEG"}, 2, 11},
             {"1.2.4", "Roe, Richard", "P-18", "2023-01-02", "head", {"MR"}, -1, -1}};
  series = {{kStudy, kSeries, 3, "CT", "chest", 10}, {kStudy, "1.2.3.2", 4, "SEG", "lungs", 1}};
}

std::unique_ptr<Archive> FakeArchive::open(const ArchiveServer& to) { return std::make_unique<Connection>(*this, to); }

void ArchiveFixture::SetUp() {
  WindowTest::SetUp();
  if (IsSkipped()) return;
  // Set after the window exists, because OpenGL drivers also use a cache folder.
  for (const auto& [name, value] : {std::pair("XDG_CONFIG_HOME", "config"), std::pair("XDG_CACHE_HOME", "cache")}) {
    environment_[name] = qgetenv(name);
    qputenv(name, folder_.filePath(value).toUtf8());
  }
  window_->archive().set_opener([this](const ArchiveServer& server) { return fake_.open(server); });
}

void ArchiveFixture::TearDown() {
  fake_.blocked = false;
  WindowTest::TearDown();
  for (const auto& [name, value] : environment_)
    value.isEmpty() ? qunsetenv(name.c_str()) : qputenv(name.c_str(), value);
}

void ArchiveFixture::write_two_servers() {
  ArchiveServer one = archive_server_at("http://127.0.0.1:9/dicom-web"), two = archive_server_at("TWO@127.0.0.1:9");
  one.name = "one", two.name = "two";
  write_archive_servers({one, two});
}

std::vector<std::string> ArchiveFixture::cached() const {
  std::vector<std::string> names;
  const fs::path root = ArchiveCache::archive_cache_folder();
  std::error_code failure;  // entries may be removed meanwhile
  for (fs::recursive_directory_iterator it(root, failure), end; !failure && it != end; it.increment(failure)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) names.push_back(it->path().lexically_relative(root).string());
  }
  return names;
}

ArchiveDialog* ArchiveFixture::find_dialog() {
  window_->actions()[Act::Archive]->trigger();
  auto* dialog = window_->findChild<ArchiveDialog*>();
  return dialog && dialog->isVisible() ? dialog : nullptr;
}

SendDialog* ArchiveFixture::send_dialog() {
  window_->actions()[Act::SendBack]->trigger();
  auto* dialog = window_->findChild<SendDialog*>();
  return dialog && dialog->isVisible() ? dialog : nullptr;
}

void ArchiveFixture::click(QWidget& dialog, const char* button) {
  auto* found = dialog.findChild<QAbstractButton*>(button);
  ASSERT_NE(found, nullptr) << button;
  ASSERT_TRUE(found->isEnabled() && found->isVisible()) << button << ": " << found->toolTip().toStdString();
  // Only the indicator and the text of a check box react to clicks.
  const int x = found->isCheckable() ? 8 : found->width() / 2;
  QTest::mouseClick(found, Qt::LeftButton, {}, QPoint(x, found->height() / 2));
}

void ArchiveFixture::type(QWidget& field, const QString& text) {
  if (auto* line = qobject_cast<QLineEdit*>(&field)) line->selectAll();
  QTest::keyClick(&field, Qt::Key_Delete);
  QTest::keyClicks(&field, text);
}

QTreeWidget& ArchiveFixture::results(const ArchiveDialog& dialog) {
  return *dialog.findChild<QTreeWidget*>("archive_results");
}

ArchiveDialog* ArchiveFixture::select_first_series() {
  ArchiveDialog* dialog = find_dialog();
  if (!dialog) return nullptr;
  click(*dialog, "archive_search");
  QTreeWidget& tree = results(*dialog);
  if (!wait_until([&] { return tree.topLevelItemCount() > 0 && !dialog->task().busy(); })) return nullptr;
  QTest::keyClick(&tree, Qt::Key_Return);
  if (!wait_until([&] { return tree.topLevelItem(0)->childCount() > 0 && !dialog->task().busy(); })) return nullptr;
  tree.setCurrentItem(tree.topLevelItem(0)->child(0));
  return dialog;
}

void ArchiveFixture::open_dicom_with_mesh() {
  test::write_series(place("image"), slice_of_study(), 10);
  window_->files().open(folder_.filePath("image"));
  ASSERT_TRUE(wait_until([this] { return bench().has_volume(); }));
  bench().apply(AddMesh{"ball", Seed{bench().session().volume().geometry().centre_mm(), 4}, {}, 0});
  bench().pause();
}

}  // namespace simplexseg
