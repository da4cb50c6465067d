// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/run_state.h"

#include <QCoreApplication>
#include <QLocale>
#include <QStringList>
#include <algorithm>

#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

QString tr(const char* text) { return QCoreApplication::translate("RunState", text); }

bool leaks(const MeshItem& item) { return item.field && item.field->leaks && !item.locked; }

}  // namespace

RunState run_state(const Workbench& workbench, const FrameLoop& loop) {
  const std::vector<MeshItem>& meshes = workbench.scene().meshes;
  if (meshes.empty()) return RunState::Nothing;
  if (workbench.failed()) return RunState::Failed;
  if (std::any_of(meshes.begin(), meshes.end(), leaks)) return RunState::Leaking;
  if (!workbench.running()) return RunState::Paused;
  return loop.at_rest() ? RunState::AtRest : RunState::Running;
}

QString text_of(RunState state, const FrameLoop& loop) {
  switch (state) {
    case RunState::Nothing:
      return tr("no mesh yet");
    case RunState::Running:
      return loop.steps_per_second() > 0 ? tr("running, %1 steps/s").arg(loop.steps_per_second(), 0, 'f', 0)
                                         : tr("running");
    case RunState::AtRest:
      return tr("at rest");
    case RunState::Paused:
      return tr("paused");
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

MeshState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh) {
  const Session& session = workbench.session();
  const MeshItem& item = workbench.scene().meshes[mesh];
  if (item.locked) return {tr("locked"), false};
  if (leaks(item)) return {tr("leaking"), true};
  if (!faults_of(workbench, mesh).isEmpty()) return {tr("folded"), true};
  if (!workbench.running()) return {tr("paused"), false};
  if (session.learning() == item.id) return {tr("learning"), false};
  if (loop.at_rest()) return {tr("at rest"), false};
  return {tr("moving"), false};
}

}  // namespace simplexseg
