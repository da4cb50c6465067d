// SPDX-License-Identifier: Apache-2.0
#include "gui/look/connection_fields.h"

#include <QComboBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <algorithm>

#include "core/error.h"
#include "core/number_text.h"

namespace simplexseg {
namespace {

/// Text field with a button that opens a file dialog.
class FileField : public QWidget {
 public:
  FileField(QLineEdit* line, const QString& title, QWidget* parent)
      : QWidget(parent), choose_(new QPushButton(QObject::tr("Choose..."), this)) {
    auto* row = new QHBoxLayout(this);
    row->setContentsMargins(0, 0, 0, 0);
    row->addWidget(line, 1);
    row->addWidget(choose_);
    setFocusProxy(line);
    choose_->setAutoDefault(false);
    choose_->setAccessibleName(QObject::tr("Choose: %1").arg(title));
    connect(choose_, &QPushButton::clicked, line, [line, title] {
      const QString path = local_path(QFileDialog::getOpenFileUrl(line->window(), title, url_of(line->text())));
      if (!path.isEmpty()) line->setText(path);
    });
  }
  QPushButton* button() const { return choose_; }

 private:
  QPushButton* choose_;
};

}  // namespace

void add_row(QFormLayout& form, const QString& label, const QString& tip, QWidget* field, QWidget* row) {
  auto* title = new QLabel(label, form.parentWidget());
  title->setBuddy(field);
  field->setAccessibleName(QString(label).remove('&'));
  field->setToolTip(tip);
  form.addRow(title, row ? row : field);
}

ConnectionFields::ConnectionFields(QFormLayout& form, QWidget* parent)
    : QObject(parent),
      form_(form),
      ca_file_(new QLineEdit(parent)),
      credentials_(new QLineEdit(parent)),
      kind_(new QComboBox(parent)) {
  ca_file_->setPlaceholderText(tr("system certificates"));
  certificates_ = new FileField(ca_file_, tr("Certificates (PEM)"), parent);
  add_row(form, tr("Ce&rtificates"),
          tr("Trusted certificates (PEM) instead of the system's. The server's certificate is always verified."),
          ca_file_, certificates_);
  kind_->addItems({tr("none"), tr("in an environment variable"), tr("in a file (mode 600)")});
  add_row(form, tr("Cre&dentials"), tr("Read for each connection; never stored by the program"), kind_);
  auto* where = new FileField(credentials_, tr("File with credentials"), parent);
  add_row(form, tr("&Variable or file"), tr("Its content is USER:PASSWORD or \"bearer TOKEN\""), credentials_, where);
  where_ = where;
  choose_ = where->button();
  connect(kind_, &QComboBox::currentIndexChanged, this, [this] {
    refresh();
    emit edited();
  });
  for (QLineEdit* line : {ca_file_, credentials_})
    connect(line, &QLineEdit::textChanged, this, &ConnectionFields::edited);
  refresh();
}

ConnectionFields::Kind ConnectionFields::kind() const { return static_cast<Kind>(kind_->currentIndex()); }

std::string ConnectionFields::entered_text(const QLineEdit* line) { return line->text().trimmed().toStdString(); }
std::filesystem::path ConnectionFields::entered_path(const QLineEdit* line) { return to_path(line->text().trimmed()); }

void ConnectionFields::show(const std::filesystem::path& ca_file, const std::string& variable,
                            const std::filesystem::path& file) {
  ca_file_->setText(text(ca_file));
  credentials_->setText(variable.empty() ? text(file) : text(variable));
  kind_->setCurrentIndex(static_cast<int>(!variable.empty() ? Kind::Variable
                                          : !file.empty()   ? Kind::File
                                                            : Kind::None));
}

void ConnectionFields::set_visible(bool visible) {
  visible_ = visible;
  refresh();
}

void ConnectionFields::refresh() {
  for (QWidget* row : {certificates_, static_cast<QWidget*>(kind_)}) form_.setRowVisible(row, visible_);
  form_.setRowVisible(where_, visible_ && kind() != Kind::None);
  choose_->setVisible(kind() == Kind::File);
  credentials_->setPlaceholderText(kind() == Kind::File ? tr("path of the file") : tr("name of the variable"));
  credentials_->setAccessibleName(kind() == Kind::File ? tr("File with credentials") : tr("Variable with credentials"));
  emit rows_changed();
}

void ConnectionFields::require_named_credentials() const {
  if (kind() == Kind::None) return;
  const std::string entered = entered_text(credentials_);
  if (entered.empty()) throw Error("credentials", "no variable or file is entered", "enter one, or select \"none\"");
  // Text that is not a name may be the secret itself: it must not appear in a file or message.
  const auto is_name_character = [](char c) { return is_ascii_letter(c) || is_ascii_digit(c) || c == '_'; };
  if (kind() == Kind::Variable && !std::all_of(entered.begin(), entered.end(), is_name_character))
    throw Error("credentials", "the text is not the name of an environment variable",
                "enter a name such as SERVER_LOGIN, and store the credentials in that variable");
}

}  // namespace simplexseg
