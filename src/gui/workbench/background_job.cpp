// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/background_job.h"

#include <QThread>
#include <memory>

namespace simplexseg {

BackgroundJob::~BackgroundJob() {
  if (thread_) thread_->wait();
}

bool BackgroundJob::start(const QString& title, std::function<void()> work, std::function<void()> done) {
  if (busy()) return false;
  auto failure = std::make_shared<QString>();
  thread_ = QThread::create([work = std::move(work), failure] {
    try {
      work();
    } catch (const std::bad_alloc&) {
      *failure = tr("Out of memory: the volume does not fit; close other programs or take a smaller one");
    } catch (const std::exception& error) {
      *failure = QString::fromUtf8(error.what());
    }
  });
  connect(thread_, &QThread::finished, this, [this, failure, done = std::move(done)] {
    thread_->deleteLater();
    thread_ = nullptr;
    if (failure->isEmpty()) {
      emit succeeded();
      done();
    } else {
      emit failed(*failure);
    }
  });
  emit started(title);
  thread_->start();
  return true;
}

}  // namespace simplexseg
