// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <optional>
#include <vector>

#include "gui/window/archive_task.h"

class QComboBox;
class QLineEdit;
class QPushButton;
class QTreeWidget;
class QTreeWidgetItem;

namespace simplexseg {

/// Finds studies and their series in an archive and fetches one, beside the window: that stays in use meanwhile.
class ArchiveDialog : public QDialog {
  Q_OBJECT
 public:
  /// `job`: as ArchiveTask takes it.
  ArchiveDialog(BackgroundJob& job, const ArchiveOpener& open, QWidget* parent);

  /// Reads the file of archives again; one that is damaged is said, and left as it is.
  void read_servers();
  /// The studies that are listed.
  const std::vector<ArchiveStudy>& studies() const { return studies_; }
  const ArchiveTask& task() const { return *task_; }

  /// The first time calls off what is under way.
  void reject() override;

 signals:
  /// A series is in the cache, whole.
  void fetched(const QString& folder);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  QLayout* build_servers();
  QLayout* build_form();
  void build_results();
  void refresh();

  void add_server();
  void edit_server();
  void remove_server();
  void test_server();
  /// Replaces the server `at`, or adds one, in the file. Throws Error.
  void save_server(std::optional<std::size_t> at, const ArchiveServer& server);
  void show_servers(const std::string& current);
  const ArchiveServer* server() const;

  ArchiveQuery query() const;
  void search();
  void show_studies(FoundStudies found);
  /// Asks for the series of the first study that is unfolded without any.
  void list_next();
  void show_series(QTreeWidgetItem* study, const std::vector<ArchiveSeries>& all);
  void activate(QTreeWidgetItem* item);
  void fetch();

  std::vector<ArchiveServer> servers_;
  QString why_no_servers_;  ///< the file of them cannot be read
  std::vector<ArchiveStudy> studies_;
  QTreeWidgetItem* listing_ = nullptr;  ///< whose series are being asked for

  QComboBox* server_;
  QPushButton *add_, *edit_, *remove_, *test_;
  QLineEdit *patient_, *id_, *description_, *from_, *to_;
  QComboBox* modality_;
  QPushButton* search_;
  QTreeWidget* tree_;
  ArchiveTask* task_;
  QPushButton* fetch_;
};

}  // namespace simplexseg
