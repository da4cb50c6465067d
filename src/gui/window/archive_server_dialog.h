// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <functional>
#include <vector>

#include "archive/server.h"

class QComboBox;
class QFormLayout;
class QLabel;
class QLineEdit;
class QPushButton;
class QSpinBox;

namespace simplexseg {

/// Where an archive is. Of credentials it takes the name of a variable or a file, never these themselves.
class ArchiveServerDialog : public QDialog {
  Q_OBJECT
 public:
  /// `save` is given what was entered, and throws Error where that is refused: then the dialog says so and stays.
  ArchiveServerDialog(const ArchiveServer& server, std::function<void(const ArchiveServer&)> save, QWidget* parent);

  /// As it is entered now.
  ArchiveServer server() const;

 private:
  void refresh();
  /// Throws Error.
  void require_named_credentials() const;
  void try_to_save();

  std::function<void(const ArchiveServer&)> save_;
  QFormLayout* form_;
  std::vector<QWidget*> of_web_, of_dimse_;  ///< rows that are of one protocol alone
  QWidget* where_;                           ///< the row of credentials_
  QPushButton* choose_;                      ///< a file of these
  QLineEdit *name_, *url_, *ca_file_, *credentials_, *host_, *called_, *calling_;
  QComboBox *protocol_, *kind_;
  QSpinBox *port_, *timeout_;
  QLabel* refusal_;
};

}  // namespace simplexseg
