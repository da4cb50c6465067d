// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive/archive_task.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <atomic>

#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/workbench/background_job.h"
#include "io/platform/load_progress.h"

namespace simplexseg {

/// Progress reported by the thread.
struct ArchiveTask::Transferred {
  std::atomic<int> instances{0}, of{-1};
  std::atomic<std::uint64_t> bytes{0};
};

ArchiveTask::ArchiveTask(BackgroundJob& job, ArchiveOpener open, const QString& cancel_note, QWidget* parent)
    : QWidget(parent),
      job_(job),
      open_(std::move(open)),
      cancel_note_(cancel_note),
      line_(new QLabel(this)),
      bar_(new QProgressBar(this)),
      cancel_(new QPushButton(tr("Cance&l"), this)) {
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  line_->setObjectName("archive_line");
  line_->setWordWrap(true);
  line_->setTextFormat(Qt::PlainText);
  line_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  line_->setFocusPolicy(Qt::NoFocus);
  line_->setAlignment(Qt::AlignLeft | Qt::AlignVCenter);
  line_->setMinimumHeight(2 * line_->fontMetrics().lineSpacing() + 2);
  bar_->setAccessibleName(tr("Progress"));
  bar_->setTextVisible(false);
  bar_->setFixedSize(theme::scaled(140), theme::scaled(10));
  cancel_->setObjectName("archive_cancel");
  cancel_->setAutoDefault(false);
  cancel_->setToolTip(tr("Cancel (Esc)"));
  row->addWidget(line_, 1);
  row->addWidget(bar_);
  row->addWidget(cancel_);
  watch_.setInterval(100);
  connect(&watch_, &QTimer::timeout, this, &ArchiveTask::show_progress);
  connect(cancel_, &QPushButton::clicked, this, &ArchiveTask::cancel);
  connect(&job_, &BackgroundJob::succeeded, this, [this] {
    line_->clear();
    end();
  });
  connect(&job_, &BackgroundJob::failed, this, [this](const QString& why) {
    show_message(Severity::Failure, why);
    emit failed();
    end();
  });
  connect(&job_, &BackgroundJob::cancelled, this, [this] {
    show_message(Severity::Note, tr("Cancelled: %1").arg(cancel_note_));
    emit cancelled();
    end();
  });
  end();
}

ArchiveTask::~ArchiveTask() {
  disconnect(&job_, nullptr, this, nullptr);
  job_.cancel();
}

bool ArchiveTask::busy() const { return job_.busy(); }

void ArchiveTask::start(const QString& title, const ArchiveServer& server, Work work, std::function<void()> done) {
  if (busy()) return;
  transferred_ = std::make_shared<Transferred>();
  title_ = title;
  const auto progress = [transferred = transferred_](const ArchiveTransfer& transfer) {
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
  job_.start(
      title, [=, open = open_, work = std::move(work)] { work(*open(server), progress); }, std::move(done),
      BackgroundJob::Cancellable::Yes);
  set_role(line_, "dim");
  show_progress();
  bar_->show();
  cancel_->show();
  watch_.start();
  emit changed();
}

void ArchiveTask::cancel() { job_.cancel(); }

void ArchiveTask::show_progress() {
  const int instances = transferred_->instances, of = transferred_->of;
  const double megabytes = double(transferred_->bytes) / 1e6;
  QString text = title_;
  if (of > 0) text += tr(": %1 of %2").arg(instances).arg(of);
  if (megabytes >= 0.1) text += tr(", %1 MB").arg(megabytes, 0, 'f', 1);
  line_->setText(text);
  bar_->setRange(0, std::max(0, of));  // indeterminate while the total is unknown
  bar_->setValue(instances);
}

void ArchiveTask::end() {
  watch_.stop();
  bar_->hide();
  cancel_->hide();
  emit changed();
}

void ArchiveTask::show_message(Severity severity, const QString& text) {
  line_->setText(text.simplified());
  set_role(line_, severity == Severity::Note ? "dim" : "warning");
}

QString ArchiveTask::text() const { return line_->text(); }

}  // namespace simplexseg
