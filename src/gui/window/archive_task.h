// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QTimer>
#include <QWidget>
#include <functional>
#include <memory>

#include "archive/archive.h"
#include "gui/workbench/workbench.h"

class QLabel;
class QProgressBar;
class QPushButton;

namespace simplexseg {

class BackgroundJob;

/// How an archive is opened: open_archive(), or what a test puts in its place.
using ArchiveOpener = std::function<std::unique_ptr<Archive>(const ArchiveServer&)>;

/// The line below a dialog that says what is done with an archive, in a thread of its own, with a bar and a button that
/// calls it off, and then what came of it.
class ArchiveTask : public QWidget {
  Q_OBJECT
 public:
  using Work = std::function<void(Archive&, const ArchiveProgress&)>;

  /// `job` is this task's alone, and lives longer: whoever deletes it waits until an archive lets go. `what_stays`:
  /// said when something was called off.
  ArchiveTask(BackgroundJob& job, ArchiveOpener open, const QString& what_stays, QWidget* parent);
  /// Calls off what is under way.
  ~ArchiveTask() override;

  bool busy() const;
  /// Opens the archive in the thread and calls `work` there, which touches nothing that the window uses; then `done` in
  /// the main thread. What is thrown becomes the line. Does nothing while busy.
  void start(const QString& title, const ArchiveServer& server, Work work, std::function<void()> done);
  /// Says so; neither `done` nor a failure follows.
  void call_off();
  void say(Severity severity, const QString& text);
  QString text() const;

 signals:
  void changed();     ///< something has begun, or ended in whatever way
  void failed();      ///< and says so
  void called_off();  ///< its thread may go on for a moment

 private:
  struct Seen;
  void show_progress();
  void end();

  BackgroundJob& job_;
  ArchiveOpener open_;
  std::shared_ptr<Seen> seen_;
  QString title_, what_stays_;
  QLabel* line_;
  QProgressBar* bar_;
  QPushButton* cancel_;
  QTimer watch_;
};

}  // namespace simplexseg
