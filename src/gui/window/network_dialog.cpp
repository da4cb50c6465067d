// SPDX-License-Identifier: Apache-2.0
#include "gui/window/network_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QElapsedTimer>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QVBoxLayout>
#include <algorithm>
#include <memory>

#include "core/error.h"
#include "core/number_text.h"
#include "gui/look/connection_fields.h"
#include "gui/look/integer_box.h"
#include "gui/look/number_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/workbench/task_line.h"
#include "gui/workbench/workbench.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/scene/mesh_start.h"

namespace simplexseg {
namespace {

/// Progress of a call, whose end is unknown: the time since its start.
std::function<TaskLine::Progress()> elapsed() {
  QElapsedTimer timer;
  timer.start();
  return [timer] { return TaskLine::Progress{NetworkDialog::tr(": %1 s").arg(timer.elapsed() / 1000)}; };
}

/// Paragraph of a statement with a bold heading.
QString paragraph(const QString& heading, const QString& text) {
  return QString("<p style='margin-top: 0; margin-bottom: 6px'><b>%1</b> %2</p>")
      .arg(heading.toHtmlEscaped(), text.toHtmlEscaped());
}

}  // namespace

NetworkDialog::NetworkDialog(Workbench& workbench, ItemId mesh, BackgroundJob& job, QWidget* parent)
    : QDialog(parent), workbench_(workbench), mesh_(mesh), fields_(new QWidget(this)) {
  setObjectName("network_dialog");
  setWindowTitle(tr("Start from a network"));
  auto* column = new QVBoxLayout(this);
  const MeshItem* const item = workbench_.scene().find_mesh(mesh_);
  auto* hint =
      new QLabel(tr("A network on a server outlines '%1'. Its mask becomes the start of the segmentation, which "
                    "image and marks then correct.")
                     .arg(item ? text(item->name) : QString()),
                 this);
  hint->setTextFormat(Qt::PlainText);
  hint->setWordWrap(true);
  column->addWidget(hint);
  build_fields();
  column->addWidget(fields_);
  column->addSpacing(theme::scaled(6));
  statement_ = new QLabel(this);
  statement_->setObjectName("network_statement");
  statement_->setAccessibleName(tr("What is sent"));
  statement_->setWordWrap(true);
  statement_->setTextFormat(Qt::RichText);
  statement_->setAlignment(Qt::AlignLeft | Qt::AlignTop);
  constexpr int kLines = 7;  // longest statement, after a response
  statement_->setMinimumHeight(kLines * statement_->fontMetrics().lineSpacing());
  column->addWidget(statement_, 1);
  task_ = new TaskLine(job, tr("the segmentation has not changed"), this);
  column->addWidget(task_);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
  buttons->button(QDialogButtonBox::Close)->setAutoDefault(false);
  send_ = buttons->addButton(tr("Send &image"), QDialogButtonBox::ActionRole);
  send_->setObjectName("network_send");
  // Not the default button: a second Return after that which connects must not send the image.
  send_->setAutoDefault(false);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::rejected, this, &NetworkDialog::reject);
  connect(send_, &QPushButton::clicked, this, &NetworkDialog::send);
  connect(task_, &TaskLine::changed, this, [this] {
    refresh();
    if (!task_->busy()) (connected_ ? static_cast<QWidget*>(send_) : server_)->setFocus();
  });
  read_servers();
  refresh();
  resize(std::min(theme::scaled(600), parent->width() - 24), 0);
  fit_on_screen(*this);
  server_->setFocus();
}

void NetworkDialog::build_fields() {
  auto* form = new QFormLayout(fields_);
  form->setContentsMargins(0, 0, 0, 0);
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  auto* row = new QWidget(fields_);
  auto* line = new QHBoxLayout(row);
  line->setContentsMargins(0, 0, 0, 0);
  server_ = new QComboBox(row);
  server_->setObjectName("network_server");
  server_->setEditable(true);
  server_->setInsertPolicy(QComboBox::NoInsert);
  server_->lineEdit()->setPlaceholderText("https://host:1527");
  connect_ = new QPushButton(tr("C&onnect"), row);
  connect_->setObjectName("network_connect");
  connect_->setDefault(true);
  line->addWidget(server_, 1);
  line->addWidget(connect_);
  row->setFocusProxy(server_);
  add_row(*form, tr("&Server"),
          tr("URL of an inference server of nnInteractive or of MONAI Label, or a name of networks.json"), server_,
          row);
  connection_ = new ConnectionFields(*form, fields_);
  timeout_ = new IntegerBox(fields_);
  timeout_->setRange(1, 3600);
  timeout_->setSuffix(tr(" s"));
  timeout_->setValue(NetworkServer().timeout_s);
  add_row(*form, tr("&Time-out"), tr("Longest time without data, in which the network computes"), timeout_);
  network_ = new QComboBox(fields_);
  network_->setObjectName("network_choice");
  network_->setPlaceholderText(tr("connect first"));
  add_row(*form, tr("&Network"), tr("Network of the server that computes the mask"), network_);
  error_ = new NumberBox(fields_);
  error_->setObjectName("network_error");
  error_->setRange(kMinNetworkErrorMm, kMaxErrorMm);
  error_->setDecimals(1);
  error_->setValue(kNetworkErrorMm);
  error_->setSuffix(tr(" mm"));
  add_row(*form, tr("&Expected error"),
          tr("Expected error of the mask's surface (standard deviation): with a larger one, image and marks can change "
             "more"),
          error_);
  connect(connect_, &QPushButton::clicked, this, &NetworkDialog::connect_to_server);
  connect(server_, &QComboBox::editTextChanged, this, [this] {
    show_settings();
    forget();
  });
  connect(connection_, &ConnectionFields::edited, this, &NetworkDialog::forget);
  connect(timeout_, &QSpinBox::valueChanged, this, &NetworkDialog::forget);
}

void NetworkDialog::read_servers() {
  try {
    servers_ = read_network_servers();
  } catch (const Error& error) {
    task_->show_message(Severity::Failure, QString::fromUtf8(error.what()));
  }
  for (const NetworkServer& server : servers_) server_->addItem(text(server.name));
  show_settings();
}

NetworkServer NetworkDialog::entered_server() const {
  const std::string entered = server_->currentText().trimmed().toStdString();
  if (entered.empty()) throw Error("no server", "its address is missing", "enter a URL such as https://host:1527");
  connection_->require_named_credentials();
  NetworkServer server = find_network_server(servers_, entered);
  connection_->store_in(server);
  server.timeout_s = timeout_->value();
  require_network_server(server);
  return server;
}

void NetworkDialog::show_settings() {
  const auto listed = std::ranges::find(servers_, server_->currentText().trimmed().toStdString(), &NetworkServer::name);
  if (listed == servers_.end()) return;
  connection_->show(*listed);
  timeout_->setValue(listed->timeout_s);
}

void NetworkDialog::forget() {
  connected_.reset();
  network_->clear();
  refresh();
}

void NetworkDialog::refresh() {
  const bool busy = task_->busy();
  fields_->setEnabled(!busy);
  set_enabled(network_, connected_ && network_->count() > 1,
              connected_ ? tr("The server has one network") : tr("Connect to a server first"));
  set_enabled(send_, connected_ && !busy,
              busy ? tr("Wait for the running call, or cancel it") : tr("Connect to a server first"));
  statement_->setText(statement());
}

QString NetworkDialog::statement() const {
  if (!connected_)
    return paragraph(tr("The image is sent only when you press Send image."),
                     tr("Connect asks the server for its networks and their licence, and sends the credentials only."));
  const auto& [server, info, prompts] = *connected_;
  const bool has_position = info.protocol == NetworkInfo::Protocol::MonaiLabel;
  const auto bytes = static_cast<double>(workbench_.session().volume().bytes());
  const QString with = has_position ? tr("with size, spacing and position") : tr("with size and spacing");
  const QString way = is_protected(server.url) ? QString() : tr(" The connection is not encrypted.");
  return paragraph(tr("Will be sent to %1 (%2):").arg(text(server.url), name_of(info.protocol)),
                   tr("all voxels of the image (%1) %2, and %3. Who runs the server can store them.%4")
                       .arg(text(format_bytes(bytes)), with, text(text_of(prompts)), way)) +
         paragraph(tr("Will not be sent:"),
                   tr("names, dates and identifiers of the patient, names of files, and other "
                      "segmentations. An image can identify a person, for example by the face.")) +
         paragraph(tr("Licence of the weights, as the server states it:"),
                   info.licence.empty() ? tr("not stated. Ask who runs the server.") : text(info.licence));
}

void NetworkDialog::connect_to_server() {
  forget();
  NetworkServer server;
  try {
    server = entered_server();
  } catch (const Error& error) {
    task_->show_message(Severity::Failure, QString::fromUtf8(error.what()));
    return;
  }
  const auto info = std::make_shared<NetworkInfo>();
  task_->start(
      tr("Connecting"), [=] { *info = network_info(server, check_cancelled); },
      [=, this] { show_connected(server, *info); }, elapsed());
}

void NetworkDialog::show_connected(const NetworkServer& server, const NetworkInfo& info) {
  const MeshItem* const item = workbench_.scene().find_mesh(mesh_);
  if (!item) return reject();
  try {
    connected_ = Connected{
        server, info,
        prompts_of(workbench_.scene(), *item, workbench_.session().volume().geometry(), info.scribble_voxels)};
  } catch (const Error& error) {
    task_->show_message(Severity::Failure, QString::fromUtf8(error.what()));
    return;
  }
  for (const std::string& name : info.networks) network_->addItem(text(name));
  network_->setCurrentIndex(info.networks.empty() ? -1 : 0);  // Qt selects none beside a placeholder
  refresh();
  (network_->isEnabled() ? static_cast<QWidget*>(network_) : error_)->setFocus();
}

void NetworkDialog::send() {
  const auto start = std::make_shared<MeshStart>();
  const NetworkRequest request{workbench_.session().volume(), connected_->prompts,
                               network_->currentText().toStdString()};
  task_->start(
      tr("Waiting for %1").arg(text(connected_->server.url)),
      [=, server = connected_->server, error_mm = error_->value()] {
        *start = start_of_network(segment_by_network(server, request, check_cancelled), error_mm).start;
      },
      [=, this] { take(*start); }, elapsed());
}

void NetworkDialog::take(const MeshStart& start) {
  if (!workbench_.apply(SetStart{mesh_, start})) {
    task_->show_message(Severity::Failure, tr("The segmentation did not start from the mask; F2 shows why"));
    return;
  }
  const MeshItem* const item = workbench_.scene().find_mesh(mesh_);
  workbench_.notify(Severity::Note, tr("'%1' starts from the mask of %2. Correct it with marks.")
                                        .arg(item ? text(item->name) : QString(), text(start.network->network)));
  accept();
}

void NetworkDialog::reject() {
  if (task_->busy())
    task_->cancel();
  else
    QDialog::reject();
}

}  // namespace simplexseg
