// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>
#include <QStringList>
#include <QTimer>

#include "gui/workbench/workbench.h"

class QLabel;
class QProgressBar;
class QToolButton;

namespace simplexseg {

/// Bar with the current message or progress, near the upper edge of `over`. It covers the views without moving them,
/// and is hidden without a message. A log keeps all messages.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  explicit MessageBar(QWidget* over);
  /// Shows a message. A note disappears after 6 s; a warning or failure stays until it is closed or replaced.
  void show_message(Severity severity, const QString& text);
  /// Shows a text such as "Loading ch2.nii.gz" with a progress bar, until clear(). `may_cancel` adds a Cancel button.
  void show_progress(const QString& text, bool may_cancel = false);
  /// Sets the progress, 0..1.
  void set_fraction(double fraction);
  void clear();
  /// Removes the failure of an earlier action; called when a later action succeeds.
  void dismiss_failure();
  /// Removes the message `text` if it is shown; called when the message no longer applies.
  void dismiss(const QString& text);
  QString text() const { return text_; }
  /// All messages of this run of the program, each with its time of day.
  const QStringList& log() const { return log_; }
  void show_log();

 signals:
  void cancel_requested();

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void show_text(const QString& text, const char* background);
  void place();

  QLabel* label_;
  QProgressBar* progress_;
  QToolButton* cancel_;
  QToolButton* close_;
  QTimer hide_timer_;
  QString text_;
  QStringList log_;
  bool failure_ = false;  ///< a failure is shown
};

}  // namespace simplexseg
