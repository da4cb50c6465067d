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

/// What went wrong, what is to be known and what takes long: lies over the upper edge of `over` and moves nothing
/// there; out of the way when empty. A log keeps all messages.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  explicit MessageBar(QWidget* over);
  /// Notes go by themselves after some seconds; warnings and failures stay until closed or replaced.
  void show_message(Severity severity, const QString& text);
  /// "Loading ch2.nii.gz", with a moving bar until its length is known; until clear(). `may_cancel`: with a button.
  void show_progress(const QString& text, bool may_cancel = false);
  /// How far that is, 0..1.
  void set_fraction(double fraction);
  void clear();
  /// An action was carried out: a failure of an earlier one is no longer news.
  void forget_failure();
  /// Where this is what is shown: it is no longer so.
  void forget(const QString& text);
  QString text() const { return text_; }
  /// All messages of this run of the program, with the time of each.
  const QStringList& log() const { return log_; }
  void show_log();

 signals:
  void cancel_wanted();

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
  bool failure_ = false;  ///< what is shown is one
};

}  // namespace simplexseg
