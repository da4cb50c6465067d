// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/run_state.h"

#include <QCoreApplication>
#include <QLocale>
#include <QStringList>
#include <algorithm>

#include "gui/input/key_map.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/workbench.h"
#include "session/mesh_marks.h"

namespace simplexseg {
namespace {

QString state_text(const char* text) { return QCoreApplication::translate("RunState", text); }
QString solving_text(int percent) { return state_text("solving %1%").arg(percent); }

bool spreads(const MeshItem& item) { return item.field && item.field->leaks && !item.locked; }
bool doubtful(const MeshItem& item) { return item.field && item.field->probably_wrong() && !item.locked; }
bool has_pending_marks(const Workbench& workbench, const MeshItem& item) {
  const Session& session = workbench.session();
  return !item.locked && session.solving_mesh() != item.id &&
         is_update_cancelled(session.scene_without_poses(), item, session.volume());
}

}  // namespace

bool is_moving(const Workbench& workbench, const FrameLoop& loop) {
  return workbench.running() && !loop.settled() && !workbench.scene().meshes.empty();
}

RunState mesh_state(const Workbench& workbench, const FrameLoop& loop, std::size_t mesh) {
  const MeshItem& item = workbench.scene().meshes[mesh];
  if (item.locked) return RunState::Locked;
  if (has_pending_marks(workbench, item)) return RunState::Pending;
  if (spreads(item)) return RunState::Spreading;
  if (doubtful(item)) return RunState::Doubtful;
  const Session& session = workbench.session();
  if (is_moving(workbench, loop)) {
    if (session.solving_mesh() == item.id) return RunState::Solving;
    if (session.solving_mesh() != 0 && is_update_due(session.scene_without_poses(), item, session.volume()))
      return RunState::Waiting;
    if (!item.sleep.asleep || session.is_comparing(item.id)) return RunState::Running;
  }
  if (!faults_of(workbench, mesh).isEmpty()) return RunState::Overlapping;
  return workbench.running() ? RunState::Settled : RunState::Paused;
}

RunState run_state(const Workbench& workbench, const FrameLoop& loop) {
  const std::size_t count = workbench.scene().meshes.size();
  if (count == 0) return RunState::Nothing;
  if (workbench.failed()) return RunState::Failed;
  RunState state = RunState::Locked;
  for (std::size_t m = 0; m < count; ++m) state = std::min(state, mesh_state(workbench, loop, m));
  return state;
}

QString text_of(RunState state, int solving_percent) {
  switch (state) {
    case RunState::Nothing:
      return state_text("no segmentation yet");
    case RunState::Running:
      return state_text("running");
    case RunState::Pending:
      return state_text("marks pending");
    case RunState::Solving:
      return solving_text(solving_percent);
    case RunState::Waiting:
      return state_text("waiting");
    case RunState::Settled:
      return state_text("settled");
    case RunState::Overlapping:
      return state_text("overlaps itself");
    case RunState::Locked:
      return state_text("locked");
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

bool is_warning(RunState state) {
  return state == RunState::Failed || state == RunState::Spreading || state == RunState::Doubtful ||
         state == RunState::Pending || state == RunState::Overlapping;
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
  if (has_pending_marks(workbench, item))
    return item.has_field()
               ? state_text(
                     "You cancelled the update: the last marks are not applied yet. Choose Solve to apply them, or "
                     "undo "
                     "them.")
               : state_text("You cancelled the solution: there is no segmentation yet. Choose Solve to compute it.");
  const auto key_or_tool = [](Act act, Act tool) {
    const QString key = key_text(act);
    return key.isEmpty() ? key_hint(tool) : key;
  };
  const QString inside = key_or_tool(Act::AddInside, Act::ToolInside);
  const QString outside = key_or_tool(Act::AddOutside, Act::ToolOutside);
  if (spreads(item))
    return state_text(
               "The segmentation spreads without finding a border. Mark what is outside (%1), or place a new seed that "
               "lies completely inside the structure.")
        .arg(outside);
  if (doubtful(item))
    return state_text(
               "This segmentation is probably wrong (expected Dice: %1). Mark what belongs to it (%2) and what does "
               "not "
               "(%3), or place a new seed.")
        .arg(QString::number(item.field->expected_dice, 'f', 2), inside, outside);
  const QString faults = faults_of(workbench, mesh);
  if (faults.isEmpty() && (!item.field || item.field->expected_dice >= 1)) return {};
  if (faults.isEmpty())
    return state_text("Expected Dice with the true structure: about %1.").arg(item.field->expected_dice, 0, 'f', 2);
  return state_text(
             "%1. Labels and measurements are less reliable there. Let it run: most overlaps disappear by themselves. "
             "Otherwise raise the weight of Smoothing, delete a point that pulls across the surface, or reset the "
             "segmentation (%2).")
      .arg(faults.left(1).toUpper() + faults.mid(1), key_or_tool(Act::ResetMesh, Act::ResetMesh));
}

}  // namespace simplexseg
