// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <optional>

#include "gui/input/key_assignment.h"

class QKeySequenceEdit;
class QLabel;
class QLineEdit;
class QPushButton;
class QTreeWidget;
class QTreeWidgetItem;

namespace simplexseg {

/// Dialog in which the user changes keys. The changes take effect with OK.
class KeyDialog : public QDialog {
  Q_OBJECT
 public:
  explicit KeyDialog(QWidget* parent);

  const KeyAssignment& keys() const { return keys_; }
  /// Replaces all keys by those of a file; a failure is shown in one line and changes nothing. Likewise export_to().
  void import_from(const QString& path);
  void export_to(const QString& path);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void build_list();
  void build_editor();
  void build_buttons();
  void refresh();
  void filter(const QString& text);
  std::optional<Act> selected() const;
  /// Uses a key for the selected act, unless another act has it: then "Take over" is offered.
  void use(const QKeySequence& key);
  void take_over();
  void show_line(const QString& text);

  KeyAssignment keys_;
  std::optional<QKeySequence> wanted_;  ///< key of another act that can be taken over
  QLineEdit* search_;
  QTreeWidget* list_;
  QKeySequenceEdit* edit_;
  QPushButton *none_, *reset_, *take_over_;
  QLabel* line_;
};

}  // namespace simplexseg
