// SPDX-License-Identifier: Apache-2.0
#include "gui/window/autosave.h"

#include <QDateTime>
#include <QDialog>
#include <QDir>
#include <QFileInfo>
#include <QLabel>
#include <QListWidget>
#include <QLocale>
#include <QPushButton>
#include <QVBoxLayout>
#include <utility>

#include "core/error.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "gui/window/file_actions.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/scene/load_input.h"

namespace simplexseg {
namespace {

/// Text such as "ct.nii.gz: 3 segmentations, 12 points; 2026-11-23 14:02 (4 minutes ago)".
QString line_of(const AutosaveInfo& info) {
  const std::string& name = info.scene_file.empty() ? info.opened : info.scene_file;
  const QDateTime when = QDateTime::fromSecsSinceEpoch(info.saved_at_s);
  const qint64 minutes = when.secsTo(QDateTime::currentDateTime()) / 60;
  const QString ago = minutes < 2      ? Autosave::tr("a minute ago")
                      : minutes < 120  ? Autosave::tr("%1 minutes ago").arg(minutes)
                      : minutes < 2880 ? Autosave::tr("%1 hours ago").arg(minutes / 60)
                                       : Autosave::tr("%1 days ago").arg(minutes / 1440);
  const QString meshes = counted_text(info.meshes, "segmentation"), points = counted_text(info.points, "point");
  return Autosave::tr("%1: %2, %3; %4 (%5)")
      .arg(QFileInfo(text(name)).fileName(), meshes, points, QLocale::system().toString(when, QLocale::ShortFormat),
           ago);
}

}  // namespace

std::filesystem::path Autosave::default_root() {
  QString state = qEnvironmentVariable("XDG_STATE_HOME");
  if (state.isEmpty() || !QDir::isAbsolutePath(state)) state = QDir::homePath() + "/.local/state";
  return (state + "/simplexseg/work").toStdU16String();
}

Autosave::Autosave(Workbench& workbench, FileActions& files, BackgroundJob& job, QWidget& window,
                   const std::filesystem::path& root)
    : workbench_(workbench), files_(files), job_(job), window_(window), root_(root) {
  writer_.setMaxThreadCount(1);
  try {
    store_ = std::make_shared<AutosaveStore>(root_);
  } catch (const std::exception& error) {
    finish_save(0, QString::fromUtf8(error.what()));
  }
  saved_revision_ = workbench_.session().revision();
  interval_.setInterval(kEveryMs);
  after_action_.setSingleShot(true);
  after_action_.setInterval(kAfterActionMs);
  for (QTimer* timer : {&interval_, &after_action_}) connect(timer, &QTimer::timeout, this, &Autosave::save_now);
  interval_.start();
  // A drag is one action per frame: the work is saved when no action has followed for kAfterActionMs.
  connect(&workbench_, &Workbench::acted, &after_action_, qOverload<>(&QTimer::start));
  connect(&files_, &FileActions::name_changed, this, &Autosave::discard_if_saved);
}

Autosave::~Autosave() {
  disconnect(&workbench_, nullptr, this, nullptr);
  writer_.waitForDone();
}

void Autosave::save_now() {
  after_action_.stop();
  const std::uint64_t revision = workbench_.session().revision();
  if (!store_ || !workbench_.has_volume() || !workbench_.has_unsaved_changes() || revision == saved_revision_) return;
  if (busy_) {
    pending_ = true;
    return;
  }
  busy_ = true;
  AutosaveInfo info;
  info.opened = shown_path(files_.path());
  info.scene_file = shown_path(files_.scene_path());
  info.saved_at_s = QDateTime::currentSecsSinceEpoch();
  writer_.start([this, store = store_, scene = workbench_.scene_to_save(), info = std::move(info), revision,
                 history = workbench_.session().history()] {
    QString failure;
    try {
      store->save(scene, info, history);
    } catch (const std::exception& error) {
      failure = QString::fromUtf8(error.what());
    }
    QMetaObject::invokeMethod(this, [=, this] { finish_save(revision, failure); });
  });
}

void Autosave::finish_save(std::uint64_t revision, const QString& failure) {
  busy_ = false;
  if (failure.isEmpty()) {
    saved_revision_ = revision;
    failure_reported_ = false;
    emit saved(revision);
  } else if (!std::exchange(failure_reported_, true)) {
    workbench_.notify(Severity::Warning, tr("Autosave failed: %1").arg(failure));
  }
  if (std::exchange(pending_, false)) save_now();
  discard_if_saved();
}

void Autosave::discard_if_saved() {
  if (!store_ || workbench_.has_unsaved_changes()) return;
  saved_revision_ = workbench_.session().revision();
  writer_.start([store = store_] { store->discard(); });
}

void Autosave::offer_recovery() {
  lost_ = find_recoverable_work(root_);
  if (!lost_.empty()) open_dialog();
}

void Autosave::open_dialog() {
  auto* dialog = new QDialog(&window_);
  dialog_ = dialog;
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setObjectName("lost_work");
  dialog->setWindowTitle(tr("Recover unsaved work"));
  auto* layout = new QVBoxLayout(dialog);
  auto* explanation = new QLabel(tr("SimplexSeg closed unexpectedly. Recovered work:"), dialog);
  explanation->setWordWrap(true);
  layout->addWidget(explanation);
  auto* list = new QListWidget(dialog);
  list->setAccessibleName(tr("Recovered work"));
  list->setWordWrap(true);
  for (const RecoverableWork& work : lost_) {
    auto* entry = new QListWidgetItem(line_of(work.info), list);
    entry->setToolTip(text(work.info.opened));
  }
  list->setCurrentRow(0);
  layout->addWidget(list);
  auto* hint = new QLabel(tr("Anything not restored now will be offered again at the next start."), dialog);
  hint->setWordWrap(true);
  layout->addWidget(hint);
  auto* buttons = new QHBoxLayout;
  auto* restore_button = new QPushButton(tr("&Restore"), dialog);
  auto* discard = new QPushButton(tr("&Discard"), dialog);
  auto* later = new QPushButton(tr("&Later"), dialog);
  restore_button->setDefault(true);
  buttons->addStretch(1);
  for (QPushButton* button : {restore_button, discard, later}) buttons->addWidget(button);
  layout->addLayout(buttons);
  dialog->resize(theme::scaled(640), theme::scaled(260));
  fit_on_screen(*dialog);
  connect(restore_button, &QPushButton::clicked, this, [=, this] {
    const int row = list->currentRow();
    dialog->close();
    if (row >= 0) restore(static_cast<std::size_t>(row));
  });
  connect(discard, &QPushButton::clicked, this, [=, this] {
    const int row = list->currentRow();
    if (row < 0) return;
    lost_[static_cast<std::size_t>(row)].folder.remove();
    lost_.erase(lost_.begin() + row);
    delete list->takeItem(row);
    if (lost_.empty()) dialog->close();
  });
  connect(later, &QPushButton::clicked, dialog, &QDialog::close);
  dialog->open();
  restore_button->setFocus();
}

void Autosave::restore(std::size_t which) {
  auto input = std::make_shared<LoadedInput>();
  const std::filesystem::path scene = lost_[which].scene;
  const bool started = job_.start(
      tr("Restoring work..."), [=] { *input = load_input(scene); },
      [=, this] {
        try {
          files_.restore(std::move(*input), lost_[which].info);
        } catch (const std::exception& error) {
          workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
          return;
        }
        // This window owns the work now: the old folder of the work is deleted after the next autosave.
        auto folder = std::make_shared<LockedFolder>(std::move(lost_[which].folder));
        lost_.erase(lost_.begin() + static_cast<std::ptrdiff_t>(which));
        saved_revision_ = 0;
        const auto once = std::make_shared<QMetaObject::Connection>();
        *once = connect(this, &Autosave::saved, this, [=] {
          disconnect(*once);
          folder->remove();
        });
        save_now();
      });
  if (!started) workbench_.notify(Severity::Warning, tr("Wait until loading or saving has finished"));
}

}  // namespace simplexseg
