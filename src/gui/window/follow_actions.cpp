// SPDX-License-Identifier: Apache-2.0
#include "gui/window/follow_actions.h"

#include <QAction>
#include <QFileInfo>
#include <algorithm>
#include <utility>

#include "core/error.h"
#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/panels/plot_picture.h"
#include "gui/window/file_actions.h"
#include "gui/window/time_point_dialog.h"
#include "gui/workbench/background_job.h"
#include "gui/workbench/workbench.h"
#include "io/platform/file_names.h"
#include "io/platform/load_progress.h"
#include "io/platform/output_checks.h"
#include "io/scene/scene_io.h"

namespace simplexseg {
namespace {

/// Why the segmentations of a scene cannot be followed; empty if they can.
QString why_not_followed(const Scene& scene) {
  if (scene.meshes.empty()) return FollowActions::tr("There is no segmentation yet");
  const bool surfaces = std::ranges::none_of(scene.meshes, [](const MeshItem& m) { return m.mesh.positions.empty(); });
  return surfaces ? QString() : FollowActions::tr("Run the simulation first: a segmentation has no surface yet");
}

}  // namespace

FollowActions::FollowActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions,
                             std::function<std::unique_ptr<Session>()> make_session, QWidget& window)
    : QObject(&window),
      workbench_(workbench),
      job_(job),
      files_(files),
      actions_(actions),
      make_session_(std::move(make_session)),
      window_(window) {
  actions.on(Act::FollowStudy, [this] { ask(FollowDialog::Kind::NextStudy); });
  actions.on(Act::FollowTimePoints, [this] { ask(FollowDialog::Kind::TimePoints); });
  connect(&workbench_, &Workbench::scene_changed, this, &FollowActions::refresh);
  connect(&job_, &BackgroundJob::busy_changed, this, &FollowActions::refresh);
  refresh();
}

void FollowActions::refresh() {
  const QString why =
      job_.busy() ? tr("Wait until loading or saving has finished") : why_not_followed(workbench_.scene());
  for (const Act act : {Act::FollowStudy, Act::FollowTimePoints}) set_enabled(actions_[act], why.isEmpty(), why);
}

LoadedInput FollowActions::open_study() const {
  LoadedInput study;
  study.scene = workbench_.scene_to_save();
  study.volume = workbench_.session().volume();
  study.volume_path = study.scene.volume_path;
  if (files_.is_dicom()) study.series = workbench_.series_name().toStdString();
  study.intensity_unit = workbench_.intensity_unit();
  return study;
}

void FollowActions::ask(FollowDialog::Kind kind) {
  const bool time_points = kind == FollowDialog::Kind::TimePoints;
  const QString image = QString::fromStdString(workbench_.scene().volume_path);
  FollowDialog::Defaults defaults{
      files_.usual_folder(),
      time_points ? image : QString(),
      time_points ? files_.suggested_path("-time-points", "") : files_.suggested_path("-follow-up", ".simplexseg.json"),
      {to_path(image)}};
  if (!files_.scene_path().isEmpty()) defaults.used.push_back(to_path(files_.scene_path()));
  auto* dialog = new FollowDialog(kind, std::move(defaults), &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog, &QDialog::accepted, this, [=, this] {
    try {
      time_points ? follow_time_points(dialog->choice()) : carry_over(dialog->choice());
    } catch (const std::exception& error) {
      workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
    }
  });
  dialog->open();
}

void FollowActions::carry_over(const FollowDialog::Choice& choice) {
  if (job_.busy() || !files_.may_discard()) return;
  workbench_.pause();
  struct Result {
    LoadedInput opened;
    CarriedScene carried;
  };
  const auto result = std::make_shared<Result>();
  const std::size_t actions = workbench_.session().log().size();
  job_.start(
      tr("Carrying over to %1...").arg(QFileInfo(text(std::filesystem::path(choice.image.path))).fileName()),
      [=, study = std::make_shared<const LoadedInput>(open_study())] {
        NextStudy next = follow_image(*study, choice.image, choice.settings, choice.earlier_layer,
                                      [](double share) { report_progress(share, 1); });
        result->carried = std::move(next.followed.carried);
        check_cancelled();
        write_starts(choice.output, result->carried.scene);
        write_scene(choice.output, result->carried.scene);
        result->opened = load_input(choice.output);
        for (const std::string& warning : next.next.warnings)
          if (std::vector<std::string>& all = result->opened.warnings; std::ranges::find(all, warning) == all.end())
            all.push_back(warning);
      },
      [=, this] {
        // The open study could be edited meanwhile.
        if (workbench_.session().log().size() != actions && !files_.may_discard()) {
          workbench_.notify(Severity::Note, tr("The scene of the next study is saved: %1").arg(text(choice.output)));
          return;
        }
        try {
          files_.open_loaded(std::move(result->opened), choice.output);
        } catch (const std::exception& error) {
          workbench_.notify(Severity::Failure, QString::fromUtf8(error.what()));
          return;
        }
        const CarriedScene& carried = result->carried;
        for (const DroppedItem& item : carried.dropped)
          workbench_.notify(Severity::Note,
                            tr("%1: %2 is not carried over: %3").arg(text(item.mesh), text(item.what), text(item.why)));
        QString note = tr("Carried over %1 and %2.")
                           .arg(counted_text(static_cast<std::int64_t>(carried.scene.meshes.size()), "segmentation"),
                                counted_text(carried.kept_marks, "mark"));
        if (!carried.dropped.empty())
          note += tr(" Not carried over: %1 (F2 shows why).")
                      .arg(counted_text(static_cast<std::int64_t>(carried.dropped.size()), "item"));
        workbench_.notify(Severity::Note, note + tr(" Compare the surfaces with the image."));
        if (!workbench_.scene().layers.empty()) {
          workbench_.view.show_layers = false;  // the surfaces are compared with this study first
          workbench_.view_edited();
        }
        workbench_.run();
      },
      BackgroundJob::Cancellable::Yes);
}

void FollowActions::follow_time_points(const FollowDialog::Choice& choice) {
  if (job_.busy()) return;
  workbench_.pause();
  // A study without a file has the name of its series, which may contain any character.
  const std::string name = files_.scene_path().isEmpty()
                               ? distinct_file_names({files_.scene_name().toStdString()}, "time-point").front()
                               : to_path(files_.scene_path()).stem().string();
  const auto followed = std::make_shared<FollowedTimePoints>();
  job_.start(
      tr("Following time points..."),
      [=, make_session = make_session_, study = std::make_shared<const LoadedInput>(open_study())] {
        make_folder(choice.output);
        *followed = simplexseg::follow_time_points(*study, choice.image.path, choice.settings, choice.output, name,
                                                   make_session, [](double share) { report_progress(share, 1); });
        for (const char* ending : {"-curve.csv", "-curve.png"})
          save_plot(text(choice.output / (name + ending)), curve_plot(followed->points), curve_csv(followed->points));
      },
      [=, this] {
        for (const std::string& warning : followed->warnings) workbench_.notify(Severity::Warning, text(warning));
        workbench_.notify(Severity::Note,
                          tr("Followed %1; scenes and curve are in %2")
                              .arg(counted_text(static_cast<std::int64_t>(followed->points.size()), "time point"),
                                   text(choice.output)));
        auto* dialog = new TimePointDialog(workbench_, files_, followed->points, &window_);
        dialog->setAttribute(Qt::WA_DeleteOnClose);
        dialog->show();  // not modal: the scenes of time points are opened and corrected beside it
      },
      BackgroundJob::Cancellable::Yes);
}

}  // namespace simplexseg
