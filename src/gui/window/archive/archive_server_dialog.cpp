// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive/archive_server_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QLabel>
#include <QLineEdit>
#include <QSpinBox>
#include <QVBoxLayout>

#include "core/error.h"
#include "gui/look/connection_fields.h"
#include "gui/look/integer_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {

enum Protocol { kWeb, kDimse };

std::string utf8(const QLineEdit* line) { return line->text().trimmed().toStdString(); }

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
  const auto add = [this](const QString& label, const QString& tip, auto* field) {
    add_row(*form_, label, tip, field);
    return field;
  };
  const auto line = [this](const QString& entered) { return new QLineEdit(entered, this); };
  name_ = add(tr("&Name"), tr("Name of the archive in this program"), line(text(server.name)));
  protocol_ = add(tr("Protoco&l"), tr("Ask your PACS administrator which protocol to use"), new QComboBox(this));
  protocol_->addItems({tr("DICOMweb (QIDO-RS, WADO-RS, STOW-RS)"), tr("DIMSE (C-FIND, C-GET, C-STORE)")});
  protocol_->setCurrentIndex(server.protocol == ArchiveProtocol::DicomWeb ? kWeb : kDimse);

  url_ = add(tr("&Address"), tr("Base URL of the service, without /studies"), line(text(server.url)));
  url_->setPlaceholderText("https://host/dicom-web");
  connection_ = new ConnectionFields(*form_, this);
  connection_->show(server);
  host_ = add(tr("&Host"), tr("Network name or address of the archive"), line(text(server.host)));
  port_ = add(tr("&Port"), tr("Network port of the DICOM service"), new IntegerBox(this));
  port_->setRange(1, 65535);
  port_->setValue(server.port);
  called_ = add(tr("AE t&itle of the archive"), tr("Application entity (AE) title of the archive"),
                line(text(server.called_title)));
  calling_ = add(tr("AE title &of this program"), tr("AE title of this program, as registered in the archive"),
                 line(text(server.calling_title)));
  for (QLineEdit* title : {called_, calling_}) title->setMaxLength(16);
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
  connect(connection_, &ConnectionFields::rows_changed, this, &ArchiveServerDialog::fit_height);
  resize(theme::scaled(560), 0);
  refresh();
  name_->setFocus();
}

void ArchiveServerDialog::refresh() {
  const bool web = protocol_->currentIndex() == kWeb;
  form_->setRowVisible(url_, web);
  connection_->set_visible(web);
  for (QWidget* row : dimse_rows_) form_->setRowVisible(row, !web);
  fit_height();
}

void ArchiveServerDialog::fit_height() {
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
    connection_->store_in(server);
    return server;
  }
  server.protocol = ArchiveProtocol::Dimse;
  server.host = utf8(host_);
  server.port = port_->value();
  server.called_title = utf8(called_);
  server.calling_title = utf8(calling_);
  return server;
}

void ArchiveServerDialog::try_to_save() {
  try {
    const ArchiveServer entered = server();
    if (protocol_->currentIndex() == kWeb) connection_->require_named_credentials();
    save_(entered);
    accept();
  } catch (const std::exception& error) {
    refusal_->setText(QString::fromUtf8(error.what()));
  }
}

}  // namespace simplexseg
