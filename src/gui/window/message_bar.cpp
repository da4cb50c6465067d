// SPDX-License-Identifier: Apache-2.0
#include "gui/window/message_bar.h"

#include <QDialog>
#include <QDialogButtonBox>
#include <QEvent>
#include <QHBoxLayout>
#include <QLabel>
#include <QPlainTextEdit>
#include <QProgressBar>
#include <QTime>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>

#include "gui/look/widgets.h"

namespace simplexseg {
namespace {

constexpr const char* kNoteBackground = "#2d4a63";
constexpr int kWidest = 760;  // largest width, logical pixels; longer lines are hard to read
constexpr int kMargin = 28;   // distance from the edges, logical pixels; leaves the titles of the views visible

const char* background_of(Severity severity) {
  switch (severity) {
    case Severity::Failure:
      return "#7a2e2e";
    case Severity::Warning:
      return "#6b5420";
    case Severity::Note:
      break;
  }
  return kNoteBackground;
}

const char* word_for(Severity severity) {
  switch (severity) {
    case Severity::Failure:
      return "failed: ";
    case Severity::Warning:
      return "warning: ";
    case Severity::Note:
      break;
  }
  return "";
}

}  // namespace

MessageBar::MessageBar(QWidget* over) : QFrame(over) {
  setObjectName("message_bar");
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(12, 6, 6, 6);
  label_ = new QLabel(this);
  label_->setTextFormat(Qt::PlainText);
  label_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  label_->setWordWrap(true);
  progress_ = new QProgressBar(this);
  progress_->setRange(0, 0);
  progress_->setTextVisible(false);
  progress_->setFixedSize(140, 10);
  cancel_ = new QToolButton(this);
  cancel_->setObjectName("cancel_loading");
  cancel_->setText(tr("Cancel"));
  cancel_->setToolTip(tr("Cancel loading; the current scene stays open"));
  cancel_->hide();
  connect(cancel_, &QToolButton::clicked, this, &MessageBar::cancel_requested);
  close_ = new QToolButton(this);
  close_->setText(QString(QChar(0x00d7)));
  close_->setToolTip(tr("Close this message; Help > Messages lists all messages"));
  close_->setAccessibleName(tr("Close this message"));
  close_->setAutoRaise(true);
  layout->addWidget(label_, 1);
  layout->addWidget(progress_);
  layout->addWidget(cancel_);
  layout->addWidget(close_, 0, Qt::AlignTop);
  connect(close_, &QToolButton::clicked, this, &MessageBar::clear);
  hide_timer_.setSingleShot(true);
  connect(&hide_timer_, &QTimer::timeout, this, &MessageBar::clear);
  over->installEventFilter(this);
  hide();
}

bool MessageBar::eventFilter(QObject* watched, QEvent* event) {
  if (watched == parent() && event->type() == QEvent::Resize) place();
  return QFrame::eventFilter(watched, event);
}

void MessageBar::place() {
  if (isHidden()) return;
  const QWidget* over = parentWidget();
  const int most = std::max(200, std::min(kWidest, over->width() - 2 * kMargin));
  const int beside = sizeHint().width() - label_->sizeHint().width();
  const int line = label_->fontMetrics().horizontalAdvance(text_) + 8 + beside;
  const int width = std::min(most, line);
  resize(width, layout()->heightForWidth(width));
  move((over->width() - width) / 2, kMargin);
  raise();
}

void MessageBar::show_text(const QString& text, const char* background) {
  hide_timer_.stop();
  text_ = text.simplified();
  label_->setText(text_);
  setStyleSheet(
      QString("#message_bar { background: %1; border: 1px solid rgba(255, 255, 255, 50); border-radius: 4px; }")
          .arg(background));
  show();
  place();
}

void MessageBar::show_message(Severity severity, const QString& text) {
  progress_->hide();
  cancel_->hide();
  close_->show();
  failure_ = severity == Severity::Failure;
  show_text(text, background_of(severity));
  log_ << QTime::currentTime().toString("HH:mm:ss  ") + word_for(severity) + text_;
  if (severity == Severity::Note) hide_timer_.start(6000);
}

void MessageBar::show_progress(const QString& text, bool may_cancel) {
  progress_->setRange(0, 0);
  progress_->show();
  cancel_->setVisible(may_cancel);
  close_->hide();
  failure_ = false;
  show_text(text, kNoteBackground);
}

void MessageBar::set_fraction(double fraction) {
  constexpr int kParts = 1000;
  progress_->setRange(0, kParts);
  progress_->setValue(static_cast<int>(fraction * kParts));
}

void MessageBar::clear() {
  hide_timer_.stop();
  text_.clear();
  hide();
}

void MessageBar::dismiss(const QString& text) {
  if (text_ == text.simplified()) clear();
}

void MessageBar::dismiss_failure() {
  if (failure_) clear();
}

void MessageBar::show_log() {
  auto* dialog = new QDialog(window());
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(tr("Messages"));
  dialog->resize(720, 360);
  fit_on_screen(*dialog);
  auto* layout = new QVBoxLayout(dialog);
  auto* text = new QPlainTextEdit(log_.isEmpty() ? tr("No messages yet.") : log_.join('\n'), dialog);
  text->setReadOnly(true);
  text->setAccessibleName(tr("Messages"));
  layout->addWidget(text);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, dialog);
  connect(buttons, &QDialogButtonBox::rejected, dialog, &QDialog::reject);
  layout->addWidget(buttons);
  dialog->show();
}

}  // namespace simplexseg
