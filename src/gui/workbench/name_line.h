// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QLineEdit>
#include <QPointer>
#include <functional>
#include <vector>

#include "io/scene/label_preset.h"

class QListWidget;

namespace simplexseg {

/// Field for the name of a segmentation that suggests structures of label presets below it while the user types.
/// Arrow keys and the mouse choose one, Enter accepts it; the last row keeps the typed text. The list never has the
/// focus.
class NameLine : public QLineEdit {
  Q_OBJECT
 public:
  /// `labels` returns the structures to suggest; called when the user begins to type.
  NameLine(std::function<std::vector<PresetLabel>()> labels, QWidget* parent);
  ~NameLine() override;
  /// List of the suggestions; hidden when there are none.
  QListWidget& list() const;

 signals:
  /// The user accepted a suggestion. The field contains its name and is not modified.
  void chosen(const simplexseg::PresetLabel& label);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void focusInEvent(QFocusEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;

 private:
  void suggest(const QString& typed);
  void show_list();
  /// Accepts the current row; returns false if it is the typed text.
  bool accept_row();

  std::function<std::vector<PresetLabel>()> load_;
  std::vector<PresetLabel> labels_;
  std::vector<const PresetLabel*> matches_;  ///< rows of the list; the typed text follows
  QPointer<QListWidget> list_;               ///< a part of the window while it is shown
};

}  // namespace simplexseg
