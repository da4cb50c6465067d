// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <vector>

#include "io/labels/label_mesh.h"

class QLineEdit;
class QPushButton;
class QTreeWidget;

namespace simplexseg {

/// Lists the labels of a volume by number, name and size; the user chooses one or more.
class LabelDialog : public QDialog {
  Q_OBJECT
 public:
  LabelDialog(std::vector<LabelCount> labels, QWidget* parent);
  std::vector<LabelCount> chosen() const;

 private:
  void refresh();

  std::vector<LabelCount> labels_;
  QTreeWidget* list_;
  QPushButton* create_;
};

}  // namespace simplexseg
