// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/run_state.h"

#include <QCoreApplication>
#include <QLocale>
#include <QStringList>
#include <algorithm>

#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"
#include "session/mesh_life.h"

namespace simplexseg {
namespace {

QString tr(const char* text) { return QCoreApplication::translate("RunState", text); }

bool leaks(const MeshItem& item) { return item.field && item.field->leaks && !item.locked; }
bool unsure(const MeshItem& item) { return item.field && item.field->unsure() && !item.locked; }

}  // namespace

RunState run_state(const Workbench& workbench, const FrameLoop& loop) {
  const std::vector<MeshItem>& meshes = workbench.scene().meshes;
  if (meshes.empty()) return RunState::Nothing;
  if (workbench.failed()) return RunState::Failed;
  if (std::any_of(meshes.begin(), meshes.end(), leaks)) return RunState::Leaking;
  if (std::any_of(meshes.begin(), meshes.end(), unsure)) return RunState::Unsure;
  if (!workbench.running()) return RunState::Paused;
  const Session& session = workbench.session();
  const bool waits = std::all_of(meshes.begin(), meshes.end(), [&](const MeshItem& item) {
    return item.locked || waits_for_field(item, session.volume());
  });
  if (session.learning() != 0 && (waits || loop.at_rest())) return RunState::Learning;
  return loop.at_rest() ? RunState::AtRest : RunState::Running;
}

QString text_of(RunState state, const FrameLoop& loop) {
  switch (state) {
    case RunState::Nothing:
      return tr("no mesh yet");
    case RunState::Running:
      return loop.steps_per_second() > 0 ? tr("running, %1 steps/s").arg(loop.steps_per_second(), 0, 'f', 0)
                                         : tr("running");
    case RunState::Learning:
      return tr("learning");
    case RunState::AtRest:
      return tr("at rest");
    case RunState::Paused:
      return tr("paused");
    case RunState::Unsure:
      return tr("unsure");
    case RunState::Leaking:
      return tr("leaking");
    case RunState::Failed:
      return tr("error");
  }
  return {};
}

QString faults_of(const Workbench& workbench, std::size_t mesh) {
  const StepOutcome& outcome = workbench.session().last_outcome();
  QStringList faults;
  if (mesh >= outcome.folded_vertices.size()) return {};
  if (outcome.inside_out[mesh]) faults << tr("inside out");
  if (outcome.folded_vertices[mesh] == 1) faults << tr("folded at 1 vertex");
  if (outcome.folded_vertices[mesh] > 1)
    faults << tr("folded at %1 vertices").arg(QLocale::c().toString(outcome.folded_vertices[mesh]));
  return faults.join(tr(" and "));
}

QString advice_of(const Workbench& workbench, std::size_t mesh) {
  const MeshItem& item = workbench.scene().meshes[mesh];
  if (leaks(item))
    return tr(
        "What looks like the object has no end nearby: mark with O what does not belong to it, or seed it wholly "
        "inside of the object");
  if (unsure(item))
    return tr("By what it has learned, little of it is right (a Dice of about %1 with the true object): mark with I "
              "and O what belongs to the object and what does not, or seed it elsewhere")
        .arg(item.field->expected_dice, 0, 'f', 2);
  const QString faults = faults_of(workbench, mesh);
  if (faults.isEmpty() && (!item.field || item.field->expected_dice >= 1)) return {};
  if (faults.isEmpty())
    return tr("By what it has learned, a Dice of about %1 with the true object is to be expected; more rather than "
              "less")
        .arg(item.field->expected_dice, 0, 'f', 2);
  return tr("%1: the surface doubles back on itself there, so that labels and figures are less sure. Let it run on: "
            "most "
            "folds go by themselves. Else raise the weight of Smoothing, delete a point that pulls across the surface, "
            "or reset the mesh (Ctrl+R).")
      .arg(faults.left(1).toUpper() + faults.mid(1));
}

MeshState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh) {
  const Session& session = workbench.session();
  const MeshItem& item = workbench.scene().meshes[mesh];
  if (item.locked) return {tr("locked"), false};
  if (leaks(item)) return {tr("leaking"), true};
  if (unsure(item)) return {tr("unsure"), true};
  if (!faults_of(workbench, mesh).isEmpty()) return {tr("folded"), true};
  if (!workbench.running()) return {tr("paused"), false};
  if (session.learning() == item.id) return {tr("learning"), false};
  if (loop.at_rest()) return {tr("at rest"), false};
  return {tr("moving"), false};
}

}  // namespace simplexseg
