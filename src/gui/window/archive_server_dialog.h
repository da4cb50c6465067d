// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <functional>

#include "archive/server.h"

class QComboBox;
class QLabel;
class QLineEdit;
class QSpinBox;
class QStackedWidget;

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
  QWidget* build_web(const ArchiveServer& server);
  QWidget* build_dimse(const ArchiveServer& server);
  void refresh();
  /// Throws Error.
  void require_named_credentials() const;
  void try_to_save();

  std::function<void(const ArchiveServer&)> save_;
  QLineEdit* name_;
  QComboBox* protocol_;
  QStackedWidget* pages_;
  QLineEdit *url_, *ca_file_;
  QComboBox* credentials_kind_;
  QLabel* credentials_label_;
  QLineEdit* credentials_;
  QWidget* choose_credentials_;
  QLineEdit *host_, *called_, *calling_;
  QSpinBox *port_, *timeout_;
  QLabel* refusal_;
};

}  // namespace simplexseg
