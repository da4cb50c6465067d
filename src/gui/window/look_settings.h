// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QSettings>
#include <optional>

#include "gui/look/theme.h"

class QApplication;
class QMenu;

namespace simplexseg {

/// The user's choice of theme and size of text: applied, remembered, and chosen in a menu. Follows the desktop while it
/// is told to.
class LookSettings : public QObject {
  Q_OBJECT
 public:
  /// Applies what was chosen last; `instead`: the theme of this start, whatever was chosen.
  explicit LookSettings(QApplication& application, std::optional<theme::Choice> instead = {});
  void fill(QMenu& menu);
  theme::Choice choice() const { return choice_; }
  void choose(theme::Choice choice);
  /// One of theme::kTextSizes; of windows that are made later.
  void choose_text(int percent);
  int text_percent() const { return text_percent_; }

 signals:
  /// For the user: the size of text changes at the next start.
  void said(const QString& text);

 private slots:
  void desktop_changed();

 private:
  void apply();

  QApplication& application_;
  QSettings settings_;
  theme::Choice choice_ = theme::Choice::Desktop;
  int text_percent_ = 100;
};

}  // namespace simplexseg
