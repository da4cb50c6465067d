// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <functional>

class QThread;

namespace simplexseg {

/// Long work in a thread of its own, one at a time, so that the window never stands still.
class BackgroundJob : public QObject {
  Q_OBJECT
 public:
  explicit BackgroundJob(QObject* parent) : QObject(parent) {}
  /// Waits for the work under way.
  ~BackgroundJob() override;
  bool busy() const { return thread_ != nullptr; }
  /// `work` runs in the thread and touches nothing that the window uses; then, in the main thread, `done` is called,
  /// or failed() is emitted with what `work` threw. Does nothing and returns false while busy.
  bool start(const QString& title, std::function<void()> work, std::function<void()> done);

 signals:
  void started(const QString& title);
  void succeeded();
  void failed(const QString& why);

 private:
  QThread* thread_ = nullptr;
};

}  // namespace simplexseg
