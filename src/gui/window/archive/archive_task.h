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

/// Function that opens an archive: open_archive(), or a replacement in tests.
using ArchiveOpener = std::function<std::unique_ptr<Archive>(const ArchiveServer&)>;

/// Status line of a dialog: runs an operation on an archive in a background thread, with a progress bar and a button
/// that cancels it, and then shows the result.
class ArchiveTask : public QWidget {
  Q_OBJECT
 public:
  using Work = std::function<void(Archive&, const ArchiveProgress&)>;

  /// `job` is used by this task only and must outlive it; the destructor of `job` waits for the thread. `cancel_note`:
  /// effect of a cancellation, appended to the message "Cancelled".
  ArchiveTask(BackgroundJob& job, ArchiveOpener open, const QString& cancel_note, QWidget* parent);
  /// Cancels the running operation.
  ~ArchiveTask() override;

  bool busy() const;
  /// Opens the archive and calls `work` in the thread, then `done` in the main thread. `work` must not use objects of
  /// the window; an exception of `work` becomes the message. Does nothing while busy.
  void start(const QString& title, const ArchiveServer& server, Work work, std::function<void()> done);
  /// Cancels the running operation and shows a message; neither `done` nor failed() follows.
  void cancel();
  void show_message(Severity severity, const QString& text);
  QString text() const;

 signals:
  void changed();    ///< an operation has started or ended
  void failed();     ///< the message shows the error
  void cancelled();  ///< the thread may still run for a moment

 private:
  struct Transferred;
  void show_progress();
  void end();

  BackgroundJob& job_;
  ArchiveOpener open_;
  std::shared_ptr<Transferred> transferred_;
  QString title_, cancel_note_;
  QLabel* line_;
  QProgressBar* bar_;
  QPushButton* cancel_;
  QTimer watch_;
};

}  // namespace simplexseg
