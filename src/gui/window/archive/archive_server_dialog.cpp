// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive/archive_server_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSpinBox>
#include <QVBoxLayout>
#include <algorithm>

#include "core/error.h"
#include "core/number_text.h"
#include "gui/look/integer_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {

enum Protocol { kWeb, kDimse };
enum Credentials { kNone, kVariable, kFile };

std::string utf8(const QLineEdit* line) { return line->text().trimmed().toStdString(); }
std::filesystem::path path_in(const QLineEdit* line) { return to_path(line->text().trimmed()); }

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

ArchiveServerDialog::ArchiveServerDialog(const ArchiveServer& server, std::function<void(const ArchiveServer&)> save,
                                         QWidget* parent)
    : QDialog(parent), save_(std::move(save)) {
  setObjectName("archive_server_dialog");
  setWindowTitle(server.name.empty() ? tr("Add an archive") : tr("Edit an archive"));
  auto* column = new QVBoxLayout(this);
  form_ = new QFormLayout;
  form_->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  column->addLayout(form_);
  const auto add = [this](const QString& label, const QString& tip, auto* field, QWidget* row = nullptr) {
    auto* title = new QLabel(label, this);
    title->setBuddy(field);
    field->setAccessibleName(QString(label).remove('&'));
    field->setToolTip(tip);
    form_->addRow(title, row ? row : field);
    return field;
  };
  const auto line = [this](const QString& entered) { return new QLineEdit(entered, this); };
  name_ = add(tr("&Name"), tr("Name of the archive in this program"), line(text(server.name)));
  protocol_ = add(tr("Protoco&l"), tr("Ask your PACS administrator which protocol to use"), new QComboBox(this));
  protocol_->addItems({tr("DICOMweb (QIDO-RS, WADO-RS, STOW-RS)"), tr("DIMSE (C-FIND, C-GET, C-STORE)")});
  protocol_->setCurrentIndex(server.protocol == ArchiveProtocol::DicomWeb ? kWeb : kDimse);

  url_ = add(tr("&Address"), tr("Base URL of the service, without /studies"), line(text(server.url)));
  url_->setPlaceholderText("https://host/dicom-web");
  ca_file_ = line(text(server.ca_file));
  ca_file_->setPlaceholderText(tr("system certificates"));
  auto* certificates = new FileField(ca_file_, tr("Certificates (PEM)"), this);
  add(tr("Ce&rtificates"),
      tr("Trusted certificates (PEM) instead of the system's. The archive's certificate is always verified."), ca_file_,
      certificates);
  kind_ = add(tr("Cre&dentials"), tr("Read for each connection; never stored by the program"), new QComboBox(this));
  kind_->addItems({tr("none"), tr("in an environment variable"), tr("in a file (mode 600)")});
  kind_->setCurrentIndex(!server.credentials_variable.empty() ? kVariable
                         : !server.credentials_file.empty()   ? kFile
                                                              : kNone);
  credentials_ =
      line(kind_->currentIndex() == kFile ? text(server.credentials_file) : text(server.credentials_variable));
  auto* where = new FileField(credentials_, tr("File with credentials"), this);
  add(tr("&Variable or file"), tr("Its content is USER:PASSWORD or \"bearer TOKEN\""), credentials_, where);
  where_ = where;
  choose_ = where->button();
  host_ = add(tr("&Host"), tr("Network name or address of the archive"), line(text(server.host)));
  port_ = add(tr("&Port"), tr("Network port of the DICOM service"), new IntegerBox(this));
  port_->setRange(1, 65535);
  port_->setValue(server.port);
  called_ = add(tr("AE t&itle of the archive"), tr("Application entity (AE) title of the archive"),
                line(text(server.called_title)));
  calling_ = add(tr("AE title &of this program"), tr("AE title of this program, as registered in the archive"),
                 line(text(server.calling_title)));
  for (QLineEdit* title : {called_, calling_}) title->setMaxLength(16);
  web_rows_ = {url_, certificates, kind_};
  dimse_rows_ = {host_, port_, called_, calling_};

  timeout_ = add(tr("&Time-out"), tr("Time without data after which the connection is closed"), new QSpinBox(this));
  timeout_->setRange(1, 3600);
  timeout_->setSuffix(tr(" s"));
  timeout_->setValue(server.timeout_s);
  refusal_ = new QLabel(this);
  refusal_->setObjectName("archive_refusal");
  refusal_->setWordWrap(true);
  refusal_->setTextFormat(Qt::PlainText);
  refusal_->setMinimumHeight(2 * refusal_->fontMetrics().lineSpacing());
  set_role(refusal_, "warning");
  column->addStretch(1);
  column->addWidget(refusal_);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Save | QDialogButtonBox::Cancel, this);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &ArchiveServerDialog::try_to_save);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(protocol_, &QComboBox::currentIndexChanged, this, &ArchiveServerDialog::refresh);
  connect(kind_, &QComboBox::currentIndexChanged, this, &ArchiveServerDialog::refresh);
  resize(theme::scaled(560), 0);
  refresh();
  name_->setFocus();
}

void ArchiveServerDialog::refresh() {
  const bool web = protocol_->currentIndex() == kWeb;
  const int kind = kind_->currentIndex();
  for (QWidget* row : web_rows_) form_->setRowVisible(row, web);
  for (QWidget* row : dimse_rows_) form_->setRowVisible(row, !web);
  form_->setRowVisible(where_, web && kind != kNone);
  choose_->setVisible(kind == kFile);
  credentials_->setPlaceholderText(kind == kFile ? tr("path of the file") : tr("name of the variable"));
  credentials_->setAccessibleName(kind == kFile ? tr("File with credentials") : tr("Variable with credentials"));
  layout()->activate();
  resize(width(), sizeHint().height());
}

ArchiveServer ArchiveServerDialog::server() const {
  ArchiveServer server;
  server.name = utf8(name_);
  server.timeout_s = timeout_->value();
  if (protocol_->currentIndex() == kWeb) {
    server.url = utf8(url_);
    while (server.url.ends_with('/')) server.url.pop_back();
    server.ca_file = path_in(ca_file_);
    if (kind_->currentIndex() == kVariable) server.credentials_variable = utf8(credentials_);
    if (kind_->currentIndex() == kFile) server.credentials_file = path_in(credentials_);
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
  const int kind = kind_->currentIndex();
  if (protocol_->currentIndex() != kWeb || kind == kNone) return;
  const std::string entered = utf8(credentials_);
  if (entered.empty()) throw Error("credentials", "no variable or file is entered", "enter one, or select \"none\"");
  // Text that is not a name may be the secret itself: it must not appear in a file or message.
  const auto is_name_character = [](char c) { return is_ascii_letter(c) || is_ascii_digit(c) || c == '_'; };
  if (kind == kVariable && !std::all_of(entered.begin(), entered.end(), is_name_character))
    throw Error("credentials", "the text is not the name of an environment variable",
                "enter a name such as ARCHIVE_LOGIN, and store the credentials in that variable");
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
