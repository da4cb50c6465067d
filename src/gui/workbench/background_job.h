// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QTimer>
#include <functional>
#include <memory>
#include <vector>

#include "io/platform/load_progress.h"

class QThread;

namespace simplexseg {

/// Runs long work in a separate thread, one job at a time, so that the window stays responsive.
class BackgroundJob : public QObject {
  Q_OBJECT
 public:
  explicit BackgroundJob(QObject* parent);
  /// Cancels the running job if it is cancellable, and waits for all threads.
  ~BackgroundJob() override;
  bool busy() const { return thread_ != nullptr; }
  /// Returns true if a job is running that the user may cancel.
  bool is_cancellable() const { return busy() && cancellable_; }

  enum class Cancellable { No, Yes };
  /// Runs `work` in the thread; `work` must not use any object of the window. Readers report their progress
  /// (io/platform/load_progress.h). Afterwards, in the main thread, emits succeeded() and calls `done`, or emits
  /// failed() with the error of `work`. While busy, does nothing and returns false.
  bool start(const QString& title, std::function<void()> work, std::function<void()> done,
             Cancellable cancellable = Cancellable::No);
  /// Cancels the running job if it is cancellable: neither `done` nor failed() follows, and another job can start at
  /// once. The thread ends when it next reports its progress, and its result is discarded.
  void cancel();

 signals:
  void started(const QString& title);
  void progressed(double fraction);  ///< fraction 0..1; ten times a second while known
  void succeeded();
  void failed(const QString& why);
  void cancelled();
  void busy_changed();  ///< with each signal above except progressed()

 private:
  QThread* thread_ = nullptr;
  std::vector<QThread*> cancelled_threads_;  ///< threads of cancelled jobs that still run
  std::shared_ptr<LoadProgress> progress_;
  bool cancellable_ = false;
  QTimer watch_;
};

}  // namespace simplexseg
