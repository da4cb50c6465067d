// SPDX-License-Identifier: Apache-2.0
#include "gui/window/message_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QProgressBar>
#include <QToolButton>

namespace simplexseg {
namespace {

constexpr const char* kNoteBackground = "#2d4a63";

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

}  // namespace

MessageBar::MessageBar(QWidget* parent) : QFrame(parent) {
  setObjectName("message_bar");
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(10, 3, 4, 3);
  label_ = new QLabel(this);
  label_->setTextFormat(Qt::PlainText);
  label_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  label_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  progress_ = new QProgressBar(this);
  progress_->setRange(0, 0);
  progress_->setTextVisible(false);
  progress_->setFixedSize(140, 10);
  close_ = new QToolButton(this);
  close_->setText(QString(QChar(0x00d7)));
  close_->setToolTip(tr("Close this message"));
  close_->setAutoRaise(true);
  layout->addWidget(label_, 1);
  layout->addWidget(progress_);
  layout->addWidget(close_);
  connect(close_, &QToolButton::clicked, this, &MessageBar::clear);
  hide_timer_.setSingleShot(true);
  connect(&hide_timer_, &QTimer::timeout, this, &MessageBar::clear);
  hide();
}

void MessageBar::show_text(const QString& text, const char* background) {
  hide_timer_.stop();
  text_ = text.simplified();
  label_->setToolTip(text_);
  setStyleSheet(QString("#message_bar { background: %1; }").arg(background));
  show();
  elide();
}

void MessageBar::show_message(Severity severity, const QString& text) {
  progress_->hide();
  close_->show();
  show_text(text, background_of(severity));
  if (severity == Severity::Note) hide_timer_.start(6000);
}

void MessageBar::show_progress(const QString& text) {
  progress_->show();
  close_->hide();
  show_text(text, kNoteBackground);
}

void MessageBar::clear() {
  hide_timer_.stop();
  text_.clear();
  hide();
}

void MessageBar::elide() { label_->setText(label_->fontMetrics().elidedText(text_, Qt::ElideRight, label_->width())); }

void MessageBar::resizeEvent(QResizeEvent* event) {
  QFrame::resizeEvent(event);
  elide();
}

}  // namespace simplexseg
