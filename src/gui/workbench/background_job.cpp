// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/background_job.h"

#include <QThread>
#include <memory>

namespace simplexseg {

BackgroundJob::BackgroundJob(QObject* parent) : QObject(parent) {
  connect(this, &BackgroundJob::started, this, &BackgroundJob::busy_changed);
  connect(this, &BackgroundJob::failed, this, &BackgroundJob::busy_changed);
  for (const auto signal : {&BackgroundJob::succeeded, &BackgroundJob::cancelled})
    connect(this, signal, this, &BackgroundJob::busy_changed);
  watch_.setInterval(100);
  connect(&watch_, &QTimer::timeout, this, [this] {
    if (progress_ && progress_->fraction() >= 0) emit progressed(progress_->fraction());
  });
}

BackgroundJob::~BackgroundJob() {
  if (progress_ && cancellable_) progress_->cancel();
  if (thread_) thread_->wait();
  for (QThread* thread : cancelled_threads_) thread->wait();
}

bool BackgroundJob::start(const QString& title, std::function<void()> work, std::function<void()> done,
                          Cancellable cancellable) {
  if (busy()) return false;
  auto failure = std::make_shared<QString>();
  progress_ = std::make_shared<LoadProgress>();
  cancellable_ = cancellable == Cancellable::Yes;
  thread_ = QThread::create([work = std::move(work), failure, progress = progress_]() mutable {
    const LoadProgress::Scope scope(*progress);
    try {
      work();
    } catch (const Cancelled&) {  // the result is not needed
    } catch (const std::bad_alloc&) {
      *failure = tr("Out of memory: the volume does not fit. Close other programs or open a smaller volume.");
    } catch (const std::exception& error) {
      *failure = QString::fromUtf8(error.what());
    }
  });
  connect(thread_, &QThread::finished, this, [this, thread = thread_, failure, done = std::move(done)] {
    thread->deleteLater();
    if (thread != thread_) {
      std::erase(cancelled_threads_, thread);
      return;
    }
    thread_ = nullptr;
    watch_.stop();
    if (failure->isEmpty()) {
      emit succeeded();
      done();
    } else {
      emit failed(*failure);
    }
  });
  emit started(title);
  watch_.start();
  thread_->start();
  return true;
}

void BackgroundJob::cancel() {
  if (!is_cancellable()) return;
  progress_->cancel();
  cancelled_threads_.push_back(thread_);
  thread_ = nullptr;
  watch_.stop();
  emit cancelled();
}

}  // namespace simplexseg
