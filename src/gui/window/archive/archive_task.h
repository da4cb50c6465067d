// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>

#include "archive/archive.h"
#include "gui/workbench/task_line.h"

namespace simplexseg {

/// Function that opens an archive: open_archive(), or a replacement in tests.
using ArchiveOpener = std::function<std::unique_ptr<Archive>(const ArchiveServer&)>;

/// Status line of a dialog that runs operations on an archive.
class ArchiveTask : public TaskLine {
 public:
  using Work = std::function<void(Archive&, const ArchiveProgress&)>;

  /// `job`, `cancel_note`: see TaskLine.
  ArchiveTask(BackgroundJob& job, ArchiveOpener open, const QString& cancel_note, QWidget* parent);

  /// Opens the archive and calls `work` in the thread, then `done` in the main thread, as TaskLine::start().
  void start(const QString& title, const ArchiveServer& server, Work work, std::function<void()> done);

 private:
  ArchiveOpener open_;
};

}  // namespace simplexseg
