// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QTimer>
#include <functional>
#include <memory>
#include <vector>

#include "io/load_progress.h"

class QThread;

namespace simplexseg {

/// Long work in a thread of its own, one at a time, so that the window never stands still.
class BackgroundJob : public QObject {
  Q_OBJECT
 public:
  explicit BackgroundJob(QObject* parent);
  /// Waits for the work under way, which is called off where it can be.
  ~BackgroundJob() override;
  bool busy() const { return thread_ != nullptr; }
  /// Whether the user may call off what is under way.
  bool may_be_called_off() const { return busy() && calling_off_; }

  enum class CallingOff { No, Yes };
  /// `work` runs in the thread and touches nothing that the window uses; what it reads reports its progress
  /// (io/load_progress.h). Then, in the main thread, `done` is called, or failed() is emitted with what `work` threw.
  /// Does nothing and returns false while busy.
  bool start(const QString& title, std::function<void()> work, std::function<void()> done,
             CallingOff calling_off = CallingOff::No);
  /// Gives up what is under way, where it may be: neither `done` nor failed() follows, and other work can be started at
  /// once. The thread ends as soon as its reader reports; what it made is dropped.
  void call_off();

 signals:
  void started(const QString& title);
  void progressed(double fraction);  ///< 0..1, ten times a second while it is known
  void succeeded();
  void failed(const QString& why);
  void called_off();

 private:
  QThread* thread_ = nullptr;
  std::vector<QThread*> leaving_;  ///< called off, not ended yet
  std::shared_ptr<LoadProgress> progress_;
  bool calling_off_ = false;
  QTimer watch_;
};

}  // namespace simplexseg
