// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive/archive_task.h"

#include <algorithm>
#include <atomic>

#include "io/platform/load_progress.h"

namespace simplexseg {
namespace {

/// Progress reported by the thread.
struct Transferred {
  std::atomic<int> instances{0}, of{-1};
  std::atomic<std::uint64_t> bytes{0};
};

}  // namespace

ArchiveTask::ArchiveTask(BackgroundJob& job, ArchiveOpener open, const QString& cancel_note, QWidget* parent)
    : TaskLine(job, cancel_note, parent), open_(std::move(open)) {}

void ArchiveTask::start(const QString& title, const ArchiveServer& server, Work work, std::function<void()> done) {
  const auto transferred = std::make_shared<Transferred>();
  const auto progress = [transferred](const ArchiveTransfer& transfer) {
    transferred->instances = transfer.instances;
    transferred->of = transfer.total;
    transferred->bytes = transfer.bytes;
    try {
      report_progress(transfer.instances, std::max(1, transfer.total));
    } catch (const Cancelled&) {
      return false;
    }
    return true;
  };
  TaskLine::start(
      title, [=, open = open_, work = std::move(work)] { work(*open(server), progress); }, std::move(done),
      [transferred] {
        const int instances = transferred->instances, of = transferred->of;
        const double megabytes = double(transferred->bytes) / 1e6;
        QString text;
        if (of > 0) text += tr(": %1 of %2").arg(instances).arg(of);
        if (megabytes >= 0.1) text += tr(", %1 MB").arg(megabytes, 0, 'f', 1);
        return Progress{text, instances, of};
      });
}

}  // namespace simplexseg
