// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QSettings>
#include <optional>

#include "gui/look/theme.h"

class QApplication;
class QMenu;

namespace simplexseg {

/// Applies and stores the theme and the text size that the user chooses in a menu. With theme::Choice::Desktop, changes
/// with the theme of the desktop.
class ThemeSettings : public QObject {
  Q_OBJECT
 public:
  /// Applies the stored choice; `instead` replaces the theme in this run of the program.
  explicit ThemeSettings(QApplication& application, std::optional<theme::Choice> instead = {});
  void fill(QMenu& menu);
  theme::Choice choice() const { return choice_; }
  void choose(theme::Choice choice);
  /// Stores the text size, one of theme::kTextSizes, for windows created later.
  void choose_text(int percent);
  int text_percent() const { return text_percent_; }

 signals:
  /// Message for the user about the new text size, which takes effect at the next start.
  void message(const QString& text);

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
