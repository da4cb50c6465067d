// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QFrame>
#include <QTimer>

#include "gui/workbench/workbench.h"

class QLabel;
class QProgressBar;
class QToolButton;

namespace simplexseg {

/// One line in the window for what went wrong, what is to be known and what takes long; out of the way when empty.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  explicit MessageBar(QWidget* parent);
  /// Notes go by themselves after some seconds; warnings and failures stay until closed or replaced.
  void show_message(Severity severity, const QString& text);
  /// "Loading ch2.nii.gz", with a moving bar; until clear().
  void show_progress(const QString& text);
  void clear();
  QString text() const { return text_; }

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void show_text(const QString& text, const char* background);
  void elide();

  QLabel* label_;
  QProgressBar* progress_;
  QToolButton* close_;
  QTimer hide_timer_;
  QString text_;
};

}  // namespace simplexseg
