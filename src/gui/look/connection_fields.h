// SPDX-License-Identifier: Apache-2.0
// Fields for the connection to a server, shared by the dialogs of archives and of segmentation servers.
#pragma once
#include <QObject>
#include <QString>
#include <filesystem>
#include <string>

#include "gui/look/qt_text.h"

class QComboBox;
class QFormLayout;
class QLineEdit;
class QPushButton;
class QWidget;

namespace simplexseg {

/// Adds a row to a form: a label with a mnemonic, and a field with the label as accessible name. `row`: widget that
/// contains the field, or null.
void add_row(QFormLayout& form, const QString& label, const QString& tip, QWidget* field, QWidget* row = nullptr);

/// Rows of a form for certificates and credentials. The program stores only the name of the environment variable, or
/// the path of the file, that contains the credentials.
class ConnectionFields : public QObject {
  Q_OBJECT
 public:
  /// Adds the rows to the end of the form, which belongs to a widget.
  ConnectionFields(QFormLayout& form, QWidget* parent);

  /// Shows the settings of a server, which has the members of WebServer of these names.
  template <class Server>
  void show(const Server& server) {
    show(server.ca_file, server.credentials_variable, server.credentials_file);
  }
  /// Stores the entered settings in a server.
  template <class Server>
  void store_in(Server& server) const {
    server.ca_file = entered_path(ca_file_);
    server.credentials_variable = kind() == Kind::Variable ? entered_text(credentials_) : "";
    server.credentials_file = kind() == Kind::File ? entered_path(credentials_) : std::filesystem::path();
  }
  /// Throws Error if credentials are selected but no variable or file is entered, or if the text entered for the
  /// variable contains characters that are invalid in a name.
  void require_named_credentials() const;
  /// Shows or hides all rows.
  void set_visible(bool visible);

 signals:
  void edited();        ///< an entry has changed
  void rows_changed();  ///< other rows are visible

 private:
  enum class Kind { None, Variable, File };
  Kind kind() const;
  void show(const std::filesystem::path& ca_file, const std::string& variable, const std::filesystem::path& file);
  void refresh();
  static std::string entered_text(const QLineEdit* line);
  static std::filesystem::path entered_path(const QLineEdit* line);

  QFormLayout& form_;
  QLineEdit *ca_file_, *credentials_;
  QComboBox* kind_;
  QWidget *certificates_, *where_;  ///< rows of ca_file_ and credentials_
  QPushButton* choose_;             ///< opens a file dialog for credentials_
  bool visible_ = true;
};

}  // namespace simplexseg
