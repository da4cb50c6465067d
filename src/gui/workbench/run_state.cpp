// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/run_state.h"

#include <QCoreApplication>
#include <QLocale>
#include <QStringList>
#include <algorithm>

#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"
#include "session/mesh_lifecycle.h"

namespace simplexseg {
namespace {

QString state_text(const char* text) { return QCoreApplication::translate("RunState", text); }
QString solving_text(int percent) { return state_text("solving %1%").arg(percent); }

bool spreads(const MeshItem& item) { return item.field && item.field->leaks && !item.locked; }
bool doubtful(const MeshItem& item) { return item.field && item.field->probably_wrong() && !item.locked; }

}  // namespace

RunState run_state(const Workbench& workbench, const FrameLoop& loop) {
  const std::vector<MeshItem>& meshes = workbench.scene().meshes;
  if (meshes.empty()) return RunState::Nothing;
  if (workbench.failed()) return RunState::Failed;
  if (std::any_of(meshes.begin(), meshes.end(), spreads)) return RunState::Spreading;
  if (std::any_of(meshes.begin(), meshes.end(), doubtful)) return RunState::Doubtful;
  if (!workbench.running()) return RunState::Paused;
  const Session& session = workbench.session();
  const bool waits = std::all_of(meshes.begin(), meshes.end(), [&](const MeshItem& item) {
    return item.locked || waits_for_field(item, session.volume());
  });
  if (session.solving_mesh() != 0 && (waits || loop.settled())) return RunState::Solving;
  return loop.settled() ? RunState::Settled : RunState::Running;
}

QString text_of(RunState state, int solving_percent) {
  switch (state) {
    case RunState::Nothing:
      return state_text("no segmentation yet");
    case RunState::Running:
      return state_text("running");
    case RunState::Solving:
      return solving_text(solving_percent);
    case RunState::Settled:
      return state_text("settled");
    case RunState::Paused:
      return state_text("paused");
    case RunState::Doubtful:
      return state_text("probably wrong");
    case RunState::Spreading:
      return state_text("spreading");
    case RunState::Failed:
      return state_text("error");
  }
  return {};
}

QString faults_of(const Workbench& workbench, std::size_t mesh) {
  const StepOutcome& outcome = workbench.session().last_outcome();
  QStringList faults;
  if (mesh >= outcome.folded_vertices.size()) return {};
  if (outcome.inverted[mesh]) faults << state_text("the surface is inverted");
  if (outcome.folded_vertices[mesh] == 1) faults << state_text("the surface overlaps itself in 1 place");
  if (outcome.folded_vertices[mesh] > 1)
    faults << state_text("the surface overlaps itself in %1 places")
                  .arg(QLocale::c().toString(outcome.folded_vertices[mesh]));
  return faults.join(state_text(" and "));
}

QString advice_of(const Workbench& workbench, std::size_t mesh) {
  const MeshItem& item = workbench.scene().meshes[mesh];
  if (spreads(item))
    return state_text(
        "The segmentation spreads without finding a border. Mark what is outside (O), or place a new seed that "
        "lies completely inside the structure.");
  if (doubtful(item))
    return state_text(
               "This segmentation is probably wrong (expected Dice: %1). Mark what belongs to it (I) and what does not "
               "(O), or place a new seed.")
        .arg(item.field->expected_dice, 0, 'f', 2);
  const QString faults = faults_of(workbench, mesh);
  if (faults.isEmpty() && (!item.field || item.field->expected_dice >= 1)) return {};
  if (faults.isEmpty())
    return state_text("Expected Dice with the true structure: about %1. The actual Dice is usually higher.")
        .arg(item.field->expected_dice, 0, 'f', 2);
  return state_text(
             "%1. Labels and measurements are less reliable there. Let it run: most overlaps disappear by themselves. "
             "Otherwise raise the weight of Smoothing, delete a point that pulls across the surface, or reset the "
             "segmentation (Ctrl+R).")
      .arg(faults.left(1).toUpper() + faults.mid(1));
}

MeshState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh) {
  const Session& session = workbench.session();
  const MeshItem& item = workbench.scene().meshes[mesh];
  if (item.locked) return {state_text("locked"), false};
  if (spreads(item)) return {state_text("spreading"), true};
  if (doubtful(item)) return {state_text("probably wrong"), true};
  if (!faults_of(workbench, mesh).isEmpty()) return {state_text("overlaps itself"), true};
  if (!workbench.running()) return {state_text("paused"), false};
  if (session.solving_mesh() == item.id) return {solving_text(workbench.solving_percent()), false};
  if (loop.settled()) return {state_text("settled"), false};
  return {state_text("running"), false};
}

}  // namespace simplexseg
