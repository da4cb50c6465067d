// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive/archive_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QGridLayout>
#include <QHeaderView>
#include <QKeyEvent>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/window/archive/archive_server_dialog.h"

namespace simplexseg {
namespace {

enum StudyColumn {
  kStudyName,
  kStudyId,
  kStudyDate,
  kStudyModality,
  kStudyDescription,
  kStudySeries,
  kStudyImages,
  kStudyColumns
};
constexpr int kUid = Qt::UserRole;

std::string utf8(const QString& text) { return text.trimmed().toStdString(); }
QString count_text(int count) { return count < 0 ? QString("?") : QString::number(count); }

QString modalities_of(const ArchiveStudy& study) {
  QStringList all;
  for (const std::string& one : study.modalities) all << text(one);
  return all.join(' ');
}

}  // namespace

ArchiveDialog::ArchiveDialog(BackgroundJob& job, const ArchiveOpener& open, QWidget* parent)
    : QDialog(parent),
      tree_(new QTreeWidget(this)),
      task_(new ArchiveTask(job, open, tr("no image was stored"), this)) {
  setObjectName("archive_dialog");
  setWindowTitle(tr("Archive"));
  resize(std::min(theme::scaled(1000), parent->width() - 24), std::min(theme::scaled(620), parent->height() - 40));
  auto* column = new QVBoxLayout(this);
  column->addLayout(build_servers());
  column->addLayout(build_form());
  build_results();
  column->addWidget(tree_, 1);
  column->addWidget(task_);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
  fetch_ = buttons->addButton(tr("&Fetch and open"), QDialogButtonBox::ActionRole);
  fetch_->setObjectName("archive_fetch");
  for (QAbstractButton* button : buttons->buttons()) static_cast<QPushButton*>(button)->setAutoDefault(false);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::rejected, this, &ArchiveDialog::reject);
  connect(fetch_, &QPushButton::clicked, this, &ArchiveDialog::fetch);
  const auto collapse = [this] {
    if (QTreeWidgetItem* study = std::exchange(listing_, nullptr)) study->setExpanded(false);
  };
  connect(task_, &ArchiveTask::failed, this, collapse);
  connect(task_, &ArchiveTask::cancelled, this, collapse);
  connect(task_, &ArchiveTask::changed, this, [this] {
    refresh();
    QMetaObject::invokeMethod(this, &ArchiveDialog::list_next, Qt::QueuedConnection);
  });
  read_servers();
  (servers_.empty() ? static_cast<QWidget*>(add_) : patient_)->setFocus();
}

QLayout* ArchiveDialog::build_servers() {
  auto* row = new QHBoxLayout;
  auto* label = new QLabel(tr("Archi&ve"), this);
  server_ = new QComboBox(this);
  server_->setObjectName("archive_server");
  server_->setAccessibleName(tr("Archive"));
  label->setBuddy(server_);
  row->addWidget(label);
  row->addWidget(server_, 1);
  const auto add_button = [&](const QString& title, const char* name, const QString& tip,
                              void (ArchiveDialog::*act)()) {
    auto* button = new QPushButton(title, this);
    button->setObjectName(name);
    button->setAutoDefault(false);
    button->setToolTip(tip);
    connect(button, &QPushButton::clicked, this, act);
    row->addWidget(button);
    return button;
  };
  add_ = add_button(tr("&Add..."), "archive_add", tr("Add an archive to this list"), &ArchiveDialog::add_server);
  edit_ = add_button(tr("&Edit..."), "archive_edit", tr("Change the address or credentials of this archive"),
                     &ArchiveDialog::edit_server);
  remove_ = add_button(tr("&Remove"), "archive_remove",
                       tr("Remove this archive from the list; the archive itself does not change"),
                       &ArchiveDialog::remove_server);
  test_ = add_button(tr("&Test"), "archive_test", tr("Test the connection"), &ArchiveDialog::test_server);
  connect(server_, &QComboBox::currentIndexChanged, this, [this] {
    show_studies({});
    refresh();
  });
  return row;
}

QLayout* ArchiveDialog::build_form() {
  auto* grid = new QGridLayout;
  const auto add = [&](int row, int at, const QString& title, QWidget* field) {
    auto* label = new QLabel(title, this);
    label->setBuddy(field);
    field->setAccessibleName(QString(title).remove('&'));
    grid->addWidget(label, row, at);
    grid->addWidget(field, row, at + 1);
  };
  const auto line = [&](const QString& hint, const QString& tip) {
    auto* field = new QLineEdit(this);
    field->setPlaceholderText(hint);
    field->setToolTip(tip);
    return field;
  };
  const QString part = tr("Part of the text, or a pattern with * and ?");
  patient_ = line(tr("any"), tr("%1, in DICOM form: DOE^J*").arg(part));
  id_ = line(tr("any"), tr("Complete ID, or a pattern with * and ?"));
  description_ = line(tr("any"), tr("Study description. %1").arg(part));
  from_ = line(tr("2024-01-31"), tr("Earliest study date; may be empty"));
  to_ = line(tr("2024-12-31"), tr("Latest study date; may be empty"));
  modality_ = new QComboBox(this);
  modality_->setEditable(true);
  modality_->addItems({"", "CT", "MR", "PT", "NM", "US", "RTDOSE", "SEG", "RTSTRUCT"});
  modality_->lineEdit()->setPlaceholderText(tr("any"));
  modality_->setToolTip(tr("Studies with a series of this modality"));
  add(0, 0, tr("Patient &name"), patient_);
  add(0, 2, tr("Patient &ID"), id_);
  add(0, 4, tr("&Modality"), modality_);
  add(1, 0, tr("&Description"), description_);
  add(1, 2, tr("Fr&om"), from_);
  add(1, 4, tr("&Until"), to_);
  search_ = new QPushButton(tr("&Search"), this);
  search_->setObjectName("archive_search");
  search_->setDefault(true);
  grid->addWidget(search_, 1, 6);
  for (const int column : {1, 3, 5}) grid->setColumnStretch(column, column == 1 ? 3 : 2);
  connect(search_, &QPushButton::clicked, this, &ArchiveDialog::search);
  return grid;
}

void ArchiveDialog::build_results() {
  tree_->setObjectName("archive_results");
  tree_->setAccessibleName(tr("Studies and their series"));
  tree_->setHeaderLabels(
      {tr("Patient"), tr("ID"), tr("Date"), tr("Modality"), tr("Description"), tr("Series"), tr("Images")});
  tree_->setAllColumnsShowFocus(true);
  tree_->setUniformRowHeights(true);
  tree_->header()->setStretchLastSection(false);
  tree_->header()->setSectionResizeMode(kStudyDescription, QHeaderView::Stretch);
  const std::pair<StudyColumn, int> widths[] = {{kStudyName, 190},    {kStudyId, 100},    {kStudyDate, 90},
                                                {kStudyModality, 84}, {kStudySeries, 56}, {kStudyImages, 60}};
  for (const auto& [column, width] : widths) tree_->setColumnWidth(column, theme::scaled(width));
  tree_->installEventFilter(this);
  connect(tree_, &QTreeWidget::itemExpanded, this, &ArchiveDialog::list_next);
  connect(tree_, &QTreeWidget::currentItemChanged, this, &ArchiveDialog::refresh);
  connect(tree_, &QTreeWidget::itemDoubleClicked, this, [this](QTreeWidgetItem* item) {
    if (item->parent()) activate(item);  // a double click on a study expands it by default
  });
}

bool ArchiveDialog::eventFilter(QObject* watched, QEvent* event) {
  if (watched == tree_ && event->type() == QEvent::KeyPress) {
    const int key = static_cast<QKeyEvent*>(event)->key();
    if (key == Qt::Key_Return || key == Qt::Key_Enter) {  // without this, the default button would search again
      activate(tree_->currentItem());
      return true;
    }
  }
  return QDialog::eventFilter(watched, event);
}

void ArchiveDialog::reject() {
  if (task_->busy())
    task_->cancel();
  else
    QDialog::reject();
}

void ArchiveDialog::refresh() {
  const bool busy = task_->busy();
  const QString why_busy = tr("Wait for the running operation, or cancel it");
  const QString why_none = why_no_servers_.isEmpty() ? tr("Add an archive first") : why_no_servers_;
  for (QPushButton* button : {edit_, remove_, test_, search_})
    set_enabled(button, server() && !busy, server() ? why_busy : why_none);
  set_enabled(add_, why_no_servers_.isEmpty() && !busy, busy ? why_busy : why_no_servers_);
  set_enabled(server_, !busy, why_busy);
  const QTreeWidgetItem* item = tree_->currentItem();
  const bool series = item && item->parent();
  set_enabled(fetch_, series && !busy, series ? why_busy : tr("Select a series of a study first"));
}

const ArchiveServer* ArchiveDialog::server() const {
  const int at = server_->currentIndex();
  return at < 0 ? nullptr : &servers_[static_cast<std::size_t>(at)];
}

void ArchiveDialog::read_servers() {
  if (task_->busy()) return;
  const std::vector<ArchiveServer> before = servers_;
  const QString previous_failure = why_no_servers_;
  const std::string current = server() ? server()->name : "";
  why_no_servers_.clear();
  try {
    servers_ = read_archive_servers();
  } catch (const std::exception& error) {
    servers_.clear();
    why_no_servers_ = QString::fromUtf8(error.what());
  }
  if (before != servers_) show_servers(current);
  if (!why_no_servers_.isEmpty())
    task_->show_message(Severity::Failure, why_no_servers_);
  else if (servers_.empty())
    task_->show_message(Severity::Note, tr("The list has no archive yet. Add one."));
  else if (!previous_failure.isEmpty())
    task_->show_message(Severity::Note, {});
  refresh();
}

void ArchiveDialog::show_servers(const std::string& current) {
  const QSignalBlocker quiet(server_);
  server_->clear();
  for (const ArchiveServer& one : servers_) {
    server_->addItem(tr("%1 (%2)").arg(text(one.name), text(address_of(one))));
    if (one.name == current) server_->setCurrentIndex(server_->count() - 1);
  }
  show_studies({});
  refresh();
}

void ArchiveDialog::save_server(std::optional<std::size_t> at, const ArchiveServer& server) {
  std::vector<ArchiveServer> servers = servers_;
  if (at)
    servers[*at] = server;
  else
    servers.push_back(server);
  write_archive_servers(servers);
  servers_ = std::move(servers);
  show_servers(server.name);
  task_->show_message(Severity::Note, {});
}

void ArchiveDialog::add_server() {
  auto* dialog = new ArchiveServerDialog(
      {}, [this](const ArchiveServer& server) { save_server({}, server); }, this);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->open();
}

void ArchiveDialog::edit_server() {
  const auto at = static_cast<std::size_t>(server_->currentIndex());
  auto* dialog = new ArchiveServerDialog(
      *server(), [this, at](const ArchiveServer& server) { save_server(at, server); }, this);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->open();
}

void ArchiveDialog::remove_server() {
  QMessageBox question(QMessageBox::Question, tr("Remove an archive"),
                       tr("Remove '%1' from the list?").arg(text(server()->name)), QMessageBox::NoButton, this);
  QPushButton* remove = question.addButton(tr("&Remove"), QMessageBox::DestructiveRole);
  QPushButton* cancel = question.addButton(tr("&Cancel"), QMessageBox::RejectRole);
  question.setDefaultButton(cancel);
  question.setEscapeButton(cancel);
  question.exec();
  if (question.clickedButton() != remove) return;
  std::vector<ArchiveServer> servers = servers_;
  servers.erase(servers.begin() + server_->currentIndex());
  try {
    write_archive_servers(servers);
    servers_ = std::move(servers);
    show_servers({});
  } catch (const std::exception& error) {
    task_->show_message(Severity::Failure, QString::fromUtf8(error.what()));
  }
}

void ArchiveDialog::test_server() {
  task_->start(
      tr("Connecting to %1").arg(text(server()->name)), *server(),
      [](Archive& archive, const ArchiveProgress& progress) { archive.check(progress); },
      [this] { task_->show_message(Severity::Note, tr("%1 responds").arg(text(server()->name))); });
}

ArchiveQuery ArchiveDialog::query() const {
  ArchiveQuery query;
  query.patient_name = utf8(patient_->text());
  query.patient_id = utf8(id_->text());
  query.modality = utf8(modality_->currentText());
  query.description = utf8(description_->text());
  const std::string from = utf8(from_->text()), to = utf8(to_->text());
  if (!from.empty() || !to.empty()) query.date = from == to ? from : from + ".." + to;
  return query;
}

void ArchiveDialog::search() {
  const ArchiveQuery criteria = query();
  try {
    dicom_date_range(criteria.date);
  } catch (const std::exception& error) {
    task_->show_message(Severity::Failure, QString::fromUtf8(error.what()));
    from_->setFocus();
    return;
  }
  auto found = std::make_shared<FoundStudies>();
  task_->start(
      tr("Searching"), *server(),
      [=](Archive& archive, const ArchiveProgress& progress) { *found = archive.find_studies(criteria, progress); },
      [=, this] {
        const bool more = found->more;
        show_studies(std::move(*found));
        const int count = static_cast<int>(studies_.size());
        QString result = count == 0   ? tr("No matching study")
                         : count == 1 ? tr("1 study")
                                      : tr("%1 studies").arg(count);
        if (more) result = tr("Only the latest %1 studies are listed: narrow the search").arg(count);
        task_->show_message(Severity::Note, result);
      });
}

void ArchiveDialog::show_studies(FoundStudies found) {
  tree_->clear();
  studies_ = std::move(found.studies);
  for (const ArchiveStudy& study : studies_) {
    auto* item = new QTreeWidgetItem(tree_);
    item->setChildIndicatorPolicy(QTreeWidgetItem::ShowIndicator);
    item->setData(0, kUid, text(study.uid));
    item->setText(kStudyName, study.patient_name.empty() ? tr("(no name)") : text(study.patient_name));
    item->setText(kStudyId, text(study.patient_id));
    item->setText(kStudyDate, text(study.date));
    item->setText(kStudyModality, modalities_of(study));
    item->setText(kStudyDescription, text(study.description));
    item->setText(kStudySeries, count_text(study.series));
    item->setText(kStudyImages, count_text(study.instances));
    for (const int number : {kStudySeries, kStudyImages})
      item->setTextAlignment(number, Qt::AlignRight | Qt::AlignVCenter);
    for (const int cut : {kStudyName, kStudyId, kStudyModality, kStudyDescription})
      item->setToolTip(cut, item->text(cut));
  }
  if (studies_.empty()) return;
  tree_->setCurrentItem(tree_->topLevelItem(0));
  tree_->setFocus();
  if (studies_.size() == 1) tree_->topLevelItem(0)->setExpanded(true);
}

void ArchiveDialog::list_next() {
  if (task_->busy()) return;
  for (int n = 0; n < tree_->topLevelItemCount(); ++n) {
    QTreeWidgetItem* item = tree_->topLevelItem(n);
    if (!item->isExpanded() || item->childCount() > 0) continue;
    listing_ = item;
    auto found = std::make_shared<std::vector<ArchiveSeries>>();
    task_->start(
        tr("Listing the series"), *server(),
        [=, study = studies_[static_cast<std::size_t>(n)].uid](Archive& archive, const ArchiveProgress& progress) {
          *found = archive.find_series(study, progress);
        },
        [=, this] { show_series(std::exchange(listing_, nullptr), *found); });
    return;
  }
}

void ArchiveDialog::show_series(QTreeWidgetItem* study, const std::vector<ArchiveSeries>& all) {
  for (const ArchiveSeries& series : all) {
    auto* item = new QTreeWidgetItem(study);
    item->setData(0, kUid, text(series.uid));
    item->setText(kStudyName, tr("Series %1").arg(series.number));
    item->setText(kStudyModality, text(series.modality));
    item->setText(kStudyDescription, text(series.description));
    item->setToolTip(kStudyDescription, item->text(kStudyDescription));
    item->setText(kStudyImages, count_text(series.instances));
    item->setTextAlignment(kStudyImages, Qt::AlignRight | Qt::AlignVCenter);
  }
  // Preselect the series with the most images.
  const auto most =
      std::max_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.instances < b.instances; });
  if (tree_->currentItem() == study && most != all.end())
    tree_->setCurrentItem(study->child(static_cast<int>(most - all.begin())));
  task_->show_message(Severity::Note, all.size() == 1 ? tr("1 series") : tr("%1 series").arg(all.size()));
}

void ArchiveDialog::activate(QTreeWidgetItem* item) {
  if (!item) return;
  if (item->parent())
    fetch();
  else
    item->setExpanded(!item->isExpanded());
}

void ArchiveDialog::fetch() {
  if (!fetch_->isEnabled()) return;
  const QTreeWidgetItem* item = tree_->currentItem();
  const std::string study = utf8(item->parent()->data(0, kUid).toString()),
                    series = utf8(item->data(0, kUid).toString());
  auto folder = std::make_shared<std::filesystem::path>();
  task_->start(
      tr("Fetching"), *server(),
      [=](Archive& archive, const ArchiveProgress& progress) {
        *folder = archive.fetch(study, series, ArchiveCache(), progress);
      },
      [=, this] { emit fetched(text(*folder)); });
}

}  // namespace simplexseg
