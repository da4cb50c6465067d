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
#include "gui/look/theme.h"
#include "gui/window/file_actions.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/load_input.h"

namespace simplexseg {
namespace {

QString text_of(const std::string& path) { return QString::fromStdString(path); }

/// "ct.nii.gz: 3 meshes, 12 points, kept 2026-11-23 14:02 (4 minutes ago)".
QString line_of(const WorkNote& note) {
  const std::string& name = note.scene_file.empty() ? note.opened : note.scene_file;
  const QDateTime when = QDateTime::fromSecsSinceEpoch(note.saved_at_s);
  const qint64 minutes = when.secsTo(QDateTime::currentDateTime()) / 60;
  const QString ago = minutes < 2      ? Autosave::tr("a minute ago")
                      : minutes < 120  ? Autosave::tr("%1 minutes ago").arg(minutes)
                      : minutes < 2880 ? Autosave::tr("%1 hours ago").arg(minutes / 60)
                                       : Autosave::tr("%1 days ago").arg(minutes / 1440);
  const QString meshes = note.meshes == 1 ? Autosave::tr("1 mesh") : Autosave::tr("%1 meshes").arg(note.meshes);
  const QString points = note.points == 1 ? Autosave::tr("1 point") : Autosave::tr("%1 points").arg(note.points);
  return Autosave::tr("%1: %2, %3, %4 vertices; kept %5 (%6)")
      .arg(QFileInfo(text_of(name)).fileName(), meshes, points)
      .arg(note.vertices)
      .arg(QLocale().toString(when, QLocale::ShortFormat), ago);
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
    keeper_ = std::make_shared<WorkKeeper>(root_);
  } catch (const std::exception& error) {
    note_kept(0, QString::fromUtf8(error.what()));
  }
  kept_revision_ = workbench_.session().revision();
  minute_.setInterval(kEveryMs);
  settle_.setSingleShot(true);
  settle_.setInterval(kAfterActionMs);
  for (QTimer* timer : {&minute_, &settle_}) connect(timer, &QTimer::timeout, this, &Autosave::keep_now);
  minute_.start();
  // A drag acts with every frame: it has ended when there is no further action for a while.
  connect(&workbench_, &Workbench::acted, &settle_, qOverload<>(&QTimer::start));
  connect(&files_, &FileActions::name_changed, this, &Autosave::forget_where_saved);
}

Autosave::~Autosave() {
  disconnect(&workbench_, nullptr, this, nullptr);
  writer_.waitForDone();
}

void Autosave::keep_now() {
  settle_.stop();
  const std::uint64_t revision = workbench_.session().revision();
  if (!keeper_ || !workbench_.has_volume() || !workbench_.has_unsaved_changes() || revision == kept_revision_) return;
  if (busy_) {
    again_ = true;
    return;
  }
  busy_ = true;
  WorkNote note;
  note.opened = files_.path().toStdString();
  note.scene_file = files_.scene_path().toStdString();
  note.saved_at_s = QDateTime::currentSecsSinceEpoch();
  writer_.start([this, keeper = keeper_, scene = workbench_.scene_to_save(), note = std::move(note), revision,
                 history = workbench_.session().history()] {
    QString failure;
    try {
      keeper->keep(scene, note, history);
    } catch (const std::exception& error) {
      failure = QString::fromUtf8(error.what());
    }
    QMetaObject::invokeMethod(this, [=, this] { note_kept(revision, failure); });
  });
}

void Autosave::note_kept(std::uint64_t revision, const QString& failure) {
  busy_ = false;
  if (failure.isEmpty()) {
    kept_revision_ = revision;
    complained_ = false;
    emit kept(revision);
  } else if (!std::exchange(complained_, true)) {
    workbench_.say(Severity::Warning, tr("The work is not kept for the case of a crash: %1").arg(failure));
  }
  if (std::exchange(again_, false)) keep_now();
  forget_where_saved();
}

void Autosave::forget_where_saved() {
  if (!keeper_ || workbench_.has_unsaved_changes()) return;
  kept_revision_ = workbench_.session().revision();
  writer_.start([keeper = keeper_] { keeper->forget(); });
}

void Autosave::offer() {
  lost_ = find_lost_work(root_);
  if (!lost_.empty()) ask();
}

void Autosave::ask() {
  auto* dialog = new QDialog(&window_);
  question_ = dialog;
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setObjectName("lost_work");
  dialog->setWindowTitle(tr("Work that was not saved"));
  auto* layout = new QVBoxLayout(dialog);
  auto* text = new QLabel(tr("SimplexSeg has ended without being asked to. This was kept:"), dialog);
  text->setWordWrap(true);
  layout->addWidget(text);
  auto* list = new QListWidget(dialog);
  list->setAccessibleName(tr("Kept work"));
  list->setWordWrap(true);
  for (const LostWork& work : lost_) {
    auto* entry = new QListWidgetItem(line_of(work.note), list);
    entry->setToolTip(text_of(work.note.opened));
  }
  list->setCurrentRow(0);
  layout->addWidget(list);
  auto* hint = new QLabel(tr("What you do not choose now is offered again at the next start."), dialog);
  hint->setWordWrap(true);
  layout->addWidget(hint);
  auto* buttons = new QHBoxLayout;
  auto* take = new QPushButton(tr("&Go on with it"), dialog);
  auto* discard = new QPushButton(tr("&Discard it"), dialog);
  auto* later = new QPushButton(tr("&Later"), dialog);
  take->setDefault(true);
  buttons->addStretch(1);
  for (QPushButton* button : {take, discard, later}) buttons->addWidget(button);
  layout->addLayout(buttons);
  dialog->resize(theme::scaled(640), theme::scaled(260));
  connect(take, &QPushButton::clicked, this, [=, this] {
    const int row = list->currentRow();
    dialog->close();
    if (row >= 0) take_up(static_cast<std::size_t>(row));
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
  take->setFocus();
}

void Autosave::take_up(std::size_t which) {
  auto input = std::make_shared<LoadedInput>();
  const std::filesystem::path scene = lost_[which].scene;
  const bool started = job_.start(
      tr("Loading the work that was kept..."), [=] { *input = load_input(scene); },
      [=, this] {
        try {
          files_.take_up(std::move(*input), lost_[which].note);
        } catch (const std::exception& error) {
          workbench_.say(Severity::Failure, QString::fromUtf8(error.what()));
          return;
        }
        // From here on it is this window's: what was lost goes when it is kept anew.
        auto folder = std::make_shared<HeldFolder>(std::move(lost_[which].folder));
        lost_.erase(lost_.begin() + static_cast<std::ptrdiff_t>(which));
        kept_revision_ = 0;
        const auto once = std::make_shared<QMetaObject::Connection>();
        *once = connect(this, &Autosave::kept, this, [=] {
          disconnect(*once);
          folder->remove();
        });
        keep_now();
      });
  if (!started) workbench_.say(Severity::Warning, tr("Wait for what is being loaded or saved"));
}

}  // namespace simplexseg
