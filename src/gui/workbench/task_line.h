// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QTimer>
#include <QWidget>
#include <functional>

#include "gui/workbench/workbench.h"

class QLabel;
class QProgressBar;
class QPushButton;

namespace simplexseg {

class BackgroundJob;

/// Status line of a dialog: runs work in a background thread, with a progress bar and a button that cancels it, and
/// then shows the result.
class TaskLine : public QWidget {
  Q_OBJECT
 public:
  /// Progress of running work, shown after its title.
  struct Progress {
    QString text;
    int value = 0, total = 0;  ///< total 0: unknown
  };

  /// `job` is used by this line only and must outlive it; the destructor of `job` waits for the thread. `cancel_note`:
  /// effect of a cancellation, appended to the message "Cancelled".
  TaskLine(BackgroundJob& job, const QString& cancel_note, QWidget* parent);
  /// Cancels the running work.
  ~TaskLine() override;

  bool busy() const;
  /// Calls `work` in the thread, then `done` in the main thread. `work` must not use objects of the window, and must
  /// call check_cancelled() or report_progress() often; an exception of it becomes the message. `progress` is called in
  /// the main thread. Does nothing while busy.
  void start(const QString& title, std::function<void()> work, std::function<void()> done,
             std::function<Progress()> progress);
  /// Cancels the running work and shows a message; neither `done` nor failed() follows.
  void cancel();
  void show_message(Severity severity, const QString& text);
  QString text() const;

 signals:
  void changed();    ///< work has started or ended
  void failed();     ///< the message shows the error
  void cancelled();  ///< the thread may still run for a moment

 private:
  void show_progress();
  void end();

  BackgroundJob& job_;
  std::function<Progress()> progress_;
  QString title_, cancel_note_;
  QLabel* line_;
  QProgressBar* bar_;
  QPushButton* cancel_;
  QTimer watch_;
};

}  // namespace simplexseg
