// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive_server_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSpinBox>
#include <QStackedWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cctype>

#include "core/error.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {

enum Credentials { kNone, kVariable, kFile };

QString text(const std::string& utf8) { return QString::fromStdString(utf8); }
QString text(const std::filesystem::path& path) { return QString::fromStdU16String(path.u16string()); }
std::string utf8(const QLineEdit* line) { return line->text().trimmed().toStdString(); }
std::filesystem::path path_in(const QLineEdit* line) { return {line->text().trimmed().toStdU16String()}; }

/// A field with its label, which its key goes to.
template <class Field>
Field* add_row(QFormLayout& form, const QString& label, const QString& tip, Field* field) {
  auto* said = new QLabel(label, field->parentWidget());
  said->setBuddy(field);
  field->setAccessibleName(QString(label).remove('&'));
  field->setToolTip(tip);
  form.addRow(said, field);
  return field;
}

/// A button beside a field that asks for a file.
QPushButton* add_chooser(QFormLayout& form, QLineEdit* field, const QString& title) {
  auto* choose = new QPushButton(QObject::tr("Choose..."), field->parentWidget());
  choose->setAutoDefault(false);
  choose->setAccessibleName(title);
  QObject::connect(choose, &QPushButton::clicked, field, [field, title] {
    const QString path = QFileDialog::getOpenFileName(field->window(), title, field->text());
    if (!path.isEmpty()) field->setText(path);
  });
  int row = 0;
  QFormLayout::ItemRole role{};
  form.getWidgetPosition(field, &row, &role);
  form.removeWidget(field);
  auto* both = new QHBoxLayout;
  both->addWidget(field, 1);
  both->addWidget(choose);
  form.setLayout(row, QFormLayout::FieldRole, both);
  return choose;
}

QFormLayout* new_form(QWidget* page) {
  auto* form = new QFormLayout(page);
  form->setContentsMargins(0, 0, 0, 0);
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  return form;
}

}  // namespace

ArchiveServerDialog::ArchiveServerDialog(const ArchiveServer& server, std::function<void(const ArchiveServer&)> save,
                                         QWidget* parent)
    : QDialog(parent), save_(std::move(save)) {
  setObjectName("archive_server_dialog");
  setWindowTitle(server.name.empty() ? tr("Add an archive") : tr("Edit an archive"));
  auto* column = new QVBoxLayout(this);
  auto* form = new_form(nullptr);
  name_ = add_row(*form, tr("&Name"), tr("What you call it"), new QLineEdit(text(server.name), this));
  protocol_ = add_row(*form, tr("Sp&eaks"), tr("Which of the two it speaks, who runs it knows"), new QComboBox(this));
  protocol_->addItems({tr("DICOMweb (QIDO-RS, WADO-RS, STOW-RS)"), tr("DICOM's own (C-FIND, C-GET, C-STORE)")});
  protocol_->setCurrentIndex(server.protocol == ArchiveProtocol::DicomWeb ? 0 : 1);
  column->addLayout(form);
  pages_ = new QStackedWidget(this);
  pages_->addWidget(build_web(server));
  pages_->addWidget(build_dimse(server));
  column->addWidget(pages_);
  auto* below = new_form(nullptr);
  timeout_ = add_row(*below, tr("&Time-out"), tr("How long nothing may come before an answer counts as lost"),
                     new QSpinBox(this));
  timeout_->setRange(1, 3600);
  timeout_->setSuffix(tr(" s"));
  timeout_->setValue(server.timeout_s);
  column->addLayout(below);
  refusal_ = new QLabel(this);
  refusal_->setObjectName("archive_refusal");
  refusal_->setWordWrap(true);
  refusal_->setTextFormat(Qt::PlainText);
  refusal_->setMinimumHeight(2 * refusal_->fontMetrics().lineSpacing());
  set_role(refusal_, "warning");
  column->addWidget(refusal_);
  column->addStretch(1);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Save | QDialogButtonBox::Cancel, this);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &ArchiveServerDialog::try_to_save);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(protocol_, &QComboBox::currentIndexChanged, pages_, &QStackedWidget::setCurrentIndex);
  connect(credentials_kind_, &QComboBox::currentIndexChanged, this, &ArchiveServerDialog::refresh);
  pages_->setCurrentIndex(protocol_->currentIndex());
  refresh();
  resize(theme::scaled(560), sizeHint().height());
  name_->setFocus();
}

QWidget* ArchiveServerDialog::build_web(const ArchiveServer& server) {
  auto* page = new QWidget(pages_);
  QFormLayout* form = new_form(page);
  url_ = add_row(*form, tr("&Address"), tr("What comes before /studies"), new QLineEdit(text(server.url), page));
  url_->setPlaceholderText("https://host/dicom-web");
  ca_file_ = add_row(*form, tr("Ce&rtificates"),
                     tr("A file (PEM) of certificates that are trusted instead of the system's; the archive's "
                        "certificate is always verified"),
                     new QLineEdit(text(server.ca_file), page));
  ca_file_->setPlaceholderText(tr("those of the system"));
  add_chooser(*form, ca_file_, tr("Certificates (PEM)"));
  credentials_kind_ = add_row(*form, tr("Cre&dentials"),
                              tr("Where the program reads them, each time; it keeps none itself"), new QComboBox(page));
  credentials_kind_->addItems({tr("none"), tr("in an environment variable"), tr("in a file of mode 600")});
  credentials_ = new QLineEdit(page);
  credentials_label_ = new QLabel(page);
  credentials_label_->setBuddy(credentials_);
  credentials_->setToolTip(tr("It holds USER:PASSWORD, or \"bearer TOKEN\""));
  form->addRow(credentials_label_, credentials_);
  choose_credentials_ = add_chooser(*form, credentials_, tr("File with credentials"));
  credentials_kind_->setCurrentIndex(!server.credentials_variable.empty() ? kVariable
                                     : !server.credentials_file.empty()   ? kFile
                                                                          : kNone);
  credentials_->setText(server.credentials_variable.empty() ? text(server.credentials_file)
                                                            : text(server.credentials_variable));
  return page;
}

QWidget* ArchiveServerDialog::build_dimse(const ArchiveServer& server) {
  auto* page = new QWidget(pages_);
  QFormLayout* form = new_form(page);
  host_ = add_row(*form, tr("&Host"), tr("Its name in the network, or its address"),
                  new QLineEdit(text(server.host), page));
  port_ = add_row(*form, tr("&Port"), tr("Where it listens"), new QSpinBox(page));
  port_->setRange(1, 65535);
  port_->setValue(server.port);
  called_ = add_row(*form, tr("&Its title"), tr("The archive's application entity title (AE title)"),
                    new QLineEdit(text(server.called_title), page));
  calling_ = add_row(*form, tr("&Our title"), tr("The AE title by which the archive knows this program"),
                     new QLineEdit(text(server.calling_title), page));
  for (QLineEdit* title : {called_, calling_}) title->setMaxLength(16);
  return page;
}

void ArchiveServerDialog::refresh() {
  const int kind = credentials_kind_->currentIndex();
  const QString name = kind == kFile ? tr("&File") : tr("&Variable");
  credentials_label_->setText(name);
  credentials_->setAccessibleName(kind == kFile ? tr("File with credentials") : tr("Variable with credentials"));
  for (QWidget* widget : {static_cast<QWidget*>(credentials_label_), static_cast<QWidget*>(credentials_)})
    widget->setVisible(kind != kNone);
  choose_credentials_->setVisible(kind == kFile);
}

ArchiveServer ArchiveServerDialog::server() const {
  ArchiveServer server;
  server.name = utf8(name_);
  server.timeout_s = timeout_->value();
  if (protocol_->currentIndex() == 0) {
    server.url = utf8(url_);
    while (server.url.ends_with('/')) server.url.pop_back();
    server.ca_file = path_in(ca_file_);
    if (credentials_kind_->currentIndex() == kVariable) server.credentials_variable = utf8(credentials_);
    if (credentials_kind_->currentIndex() == kFile) server.credentials_file = path_in(credentials_);
    return server;
  }
  server.protocol = ArchiveProtocol::Dimse;
  server.host = utf8(host_);
  server.port = port_->value();
  server.called_title = utf8(called_);
  server.calling_title = utf8(calling_);
  return server;
}

void ArchiveServerDialog::require_named_credentials() const {
  const int kind = credentials_kind_->currentIndex();
  if (kind == kNone) return;
  const std::string entered = utf8(credentials_);
  if (entered.empty()) throw Error("the credentials", "nothing says where they are", "name it, or choose none");
  // What is no name may be the secret itself, which goes into no file and no message.
  const auto in_a_name = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  if (kind == kVariable && !std::all_of(entered.begin(), entered.end(), in_a_name))
    throw Error("the variable of the credentials", "what was entered is no name of a variable",
                "give the name, as in ARCHIVE_LOGIN, and put the credentials into the variable of that name");
}

void ArchiveServerDialog::try_to_save() {
  try {
    const ArchiveServer entered = server();
    require_named_credentials();
    save_(entered);
    accept();
  } catch (const std::exception& error) {
    refusal_->setText(QString::fromUtf8(error.what()));
  }
}

}  // namespace simplexseg
