// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <optional>
#include <vector>

#include "gui/window/archive/archive_task.h"

class QComboBox;
class QLineEdit;
class QPushButton;
class QTreeWidget;
class QTreeWidgetItem;

namespace simplexseg {

/// Searches an archive for studies and series, and fetches one series. Not modal: the main window stays usable.
class ArchiveDialog : public QDialog {
  Q_OBJECT
 public:
  /// `job`: see ArchiveTask.
  ArchiveDialog(BackgroundJob& job, const ArchiveOpener& open, QWidget* parent);

  /// Reads the list of archives from its file; reports a damaged file and leaves it unchanged.
  void read_servers();
  /// Studies found by the last search.
  const std::vector<ArchiveStudy>& studies() const { return studies_; }
  const ArchiveTask& task() const { return *task_; }

  /// Cancels the running operation; closes the dialog if there is none.
  void reject() override;

 signals:
  /// A series has been fetched completely into `folder`, in the cache.
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
  /// Replaces the server with index `at`, or adds a server without `at`, and writes the list to its file. Throws Error
  /// if the file cannot be written.
  void save_server(std::optional<std::size_t> at, const ArchiveServer& server);
  void show_servers(const std::string& current);
  const ArchiveServer* server() const;

  ArchiveQuery query() const;
  void search();
  void show_studies(FoundStudies found);
  /// Requests the series of the first expanded study whose series are not listed yet.
  void list_next();
  void show_series(QTreeWidgetItem* study, const std::vector<ArchiveSeries>& all);
  void activate(QTreeWidgetItem* item);
  void fetch();

  std::vector<ArchiveServer> servers_;
  QString why_no_servers_;  ///< reason why the list of archives cannot be read; empty if it can
  std::vector<ArchiveStudy> studies_;
  QTreeWidgetItem* listing_ = nullptr;  ///< study whose series are being requested

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
