// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/task_line.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <algorithm>

#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/workbench/background_job.h"

namespace simplexseg {

TaskLine::TaskLine(BackgroundJob& job, const QString& cancel_note, QWidget* parent)
    : QWidget(parent),
      job_(job),
      cancel_note_(cancel_note),
      line_(new QLabel(this)),
      bar_(new QProgressBar(this)),
      cancel_(new QPushButton(tr("Cance&l"), this)) {
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  line_->setObjectName("task_line");
  line_->setWordWrap(true);
  line_->setTextFormat(Qt::PlainText);
  line_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  line_->setFocusPolicy(Qt::NoFocus);
  line_->setAlignment(Qt::AlignLeft | Qt::AlignVCenter);
  line_->setMinimumHeight(2 * line_->fontMetrics().lineSpacing() + 2);
  bar_->setAccessibleName(tr("Progress"));
  bar_->setTextVisible(false);
  bar_->setFixedSize(theme::scaled(140), theme::scaled(10));
  cancel_->setObjectName("task_cancel");
  cancel_->setAutoDefault(false);
  cancel_->setToolTip(tr("Cancel (Esc)"));
  row->addWidget(line_, 1);
  row->addWidget(bar_);
  row->addWidget(cancel_);
  watch_.setInterval(100);
  connect(&watch_, &QTimer::timeout, this, &TaskLine::show_progress);
  connect(cancel_, &QPushButton::clicked, this, &TaskLine::cancel);
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

TaskLine::~TaskLine() {
  disconnect(&job_, nullptr, this, nullptr);
  job_.cancel();
}

bool TaskLine::busy() const { return job_.busy(); }

void TaskLine::start(const QString& title, std::function<void()> work, std::function<void()> done,
                     std::function<Progress()> progress) {
  if (busy()) return;
  progress_ = std::move(progress);
  title_ = title;
  job_.start(title, std::move(work), std::move(done), BackgroundJob::Cancellable::Yes);
  set_role(line_, "dim");
  show_progress();
  bar_->show();
  cancel_->show();
  watch_.start();
  emit changed();
}

void TaskLine::cancel() { job_.cancel(); }

void TaskLine::show_progress() {
  const Progress progress = progress_();
  line_->setText(title_ + progress.text);
  bar_->setRange(0, std::max(0, progress.total));  // indeterminate while the total is unknown
  bar_->setValue(progress.value);
}

void TaskLine::end() {
  watch_.stop();
  bar_->hide();
  cancel_->hide();
  emit changed();
}

void TaskLine::show_message(Severity severity, const QString& text) {
  line_->setText(text.simplified());
  set_role(line_, severity == Severity::Note ? "dim" : "warning");
}

QString TaskLine::text() const { return line_->text(); }

}  // namespace simplexseg
