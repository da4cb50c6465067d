// SPDX-License-Identifier: Apache-2.0
#include "gui/window/workbench_actions.h"

#include <QAction>
#include <algorithm>
#include <utility>

#include "gui/input/action_table.h"
#include "gui/input/key_map.h"
#include "gui/look/symbols.h"
#include "gui/look/widgets.h"
#include "gui/views/view_grid.h"
#include "gui/workbench/frame_loop.h"
#include "gui/workbench/run_state.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {

constexpr std::pair<Act, Tool> kTools[] = {{Act::ToolCrosshair, Tool::Crosshair},
                                           {Act::ToolZoomPan, Tool::ZoomPan},
                                           {Act::ToolPoint, Tool::Point},
                                           {Act::ToolSeed, Tool::Seed},
                                           {Act::ToolInside, Tool::Inside},
                                           {Act::ToolOutside, Tool::Outside},
                                           {Act::ToolBox, Tool::Box},
                                           {Act::ToolBrush, Tool::Brush},
                                           {Act::ToolEraser, Tool::Eraser},
                                           {Act::ToolFreeze, Tool::Freeze},
                                           {Act::ToolRuler, Tool::Ruler},
                                           {Act::ToolAngle, Tool::Angle},
                                           {Act::ToolEllipse, Tool::Ellipse},
                                           {Act::ToolRange, Tool::Range}};

/// Sets a text such as "Undo add point", or "Undo" if `title` is empty.
void name_history_entry(QAction* action, const QString& verb, const char* title) {
  action->setText(*title ? QString("%1 %2").arg(verb, QString::fromUtf8(title)) : verb);
  // A changing text would move the other buttons of the toolbar.
  action->setIconText(QString(verb).remove('&'));
}

}  // namespace

WorkbenchActions::WorkbenchActions(Workbench& workbench, FrameLoop& loop, ViewGrid& views, ActionTable& actions,
                                   QObject* parent)
    : QObject(parent), workbench_(workbench), loop_(loop), views_(views), actions_(actions) {
  connect_tools();
  connect_editing();
  connect_meshes();
  connect_simulation();
  connect_view();
  // A key that is held must not toggle a mode or copy a mesh repeatedly.
  for (const Act act : {Act::WindowLevel, Act::Brush3d, Act::Lasso, Act::SmartBrush, Act::LocalMarks, Act::RunPause,
                        Act::LockMesh, Act::DuplicateMesh, Act::ShowMeshes, Act::ShowFill, Act::ShowField,
                        Act::ShowAxes, Act::Annotations, Act::Names, Act::Slices3d})
    actions_[act]->setAutoRepeat(false);
  connect(&workbench_, &Workbench::scene_changed, this, &WorkbenchActions::refresh);
  connect(&workbench_, &Workbench::running_changed, this, &WorkbenchActions::refresh);
  connect(&workbench_, &Workbench::view_changed, this, &WorkbenchActions::refresh_toggles);
  connect(&workbench_, &Workbench::solving_changed, this, &WorkbenchActions::refresh_solving);
  connect(&loop_, &FrameLoop::ticked, this, &WorkbenchActions::refresh_run);
  connect(&KeyMap::shared(), &KeyMap::changed, this, &WorkbenchActions::refresh);
  refresh();
  refresh_toggles();
}

void WorkbenchActions::connect_tools() {
  for (const auto& [act, tool] : kTools) {
    actions_.on_toggle(act, [this, tool = tool](bool) {
      workbench_.view.tool = tool;
      workbench_.view.window_level_armed = false;
      workbench_.view_edited();
    });
  }
}

void WorkbenchActions::connect_editing() {
  actions_.on(Act::Undo, [this] { workbench_.apply(Undo{}); });
  actions_.on(Act::Redo, [this] { workbench_.apply(Redo{}); });
  for (const auto& [act, kind] : {std::pair{Act::BoundaryHere, MarkKind::Boundary},
                                  {Act::InsideHere, MarkKind::Inside},
                                  {Act::OutsideHere, MarkKind::Outside}})
    actions_.on(act, [this, kind = kind] {
      AddPoint command{workbench_.view.active_mesh, workbench_.view.crosshair_mm, kind};
      command.local = workbench_.view.local_marks;
      workbench_.apply(command);
    });
  actions_.on(Act::PointHere, [this] {
    const ViewState& view = workbench_.view;
    if (view.selected_point) workbench_.apply(MovePoint{view.selected_point, view.crosshair_mm});
  });
  actions_.on(Act::DeletePoint, [this] {
    const ViewState& view = workbench_.view;
    if (view.hovered_point)
      workbench_.apply(DeletePoint{view.hovered_point});
    else if (const ItemId measurement =
                 view.hovered_measurement ? view.hovered_measurement : view.selected_measurement())
      workbench_.apply(DeleteMeasurement{measurement});
    else if (view.selected_point)
      workbench_.apply(DeletePoint{view.selected_point});
  });
}

void WorkbenchActions::connect_meshes() {
  const auto active = [this] { return workbench_.view.active_mesh; };
  actions_.on(Act::ResetMesh, [=, this] { workbench_.apply(ResetPose{active()}); });
  actions_.on(Act::RefineMesh, [=, this] { workbench_.apply(RefineMesh{active()}); });
  actions_.on(Act::RecordProfiles, [=, this] {
    if (!workbench_.apply(RecordProfiles{active()})) return;
    workbench_.notify(Severity::Note,
                      tr("Recorded the profiles of '%1'. The force 'Intensity profile' can now be used.")
                          .arg(QString::fromStdString(workbench_.active_mesh()->name)));
  });
  actions_.on_toggle(Act::LockMesh, [=, this](bool locked) {
    if (active()) workbench_.apply(EditMesh{active(), {}, {}, {}, {}, locked});
  });
  actions_.on(Act::DuplicateMesh, [=, this] { workbench_.apply(DuplicateMesh{active()}); });
  actions_.on(Act::MeshUp, [this] { move_mesh(-1); });
  actions_.on(Act::MeshDown, [this] { move_mesh(1); });
  actions_.on(Act::DeleteMesh, [=, this] { workbench_.apply(DeleteMesh{active()}); });
}

void WorkbenchActions::connect_simulation() {
  actions_.on_toggle(Act::RunPause, [this](bool) {
    is_moving(workbench_, loop_) ? workbench_.pause() : workbench_.run();
    refresh_run();  // a click toggles the check mark, even if the state does not change
  });
  actions_.on(Act::Step, [this] {
    workbench_.pause();
    workbench_.advance_steps(1);
  });
  actions_.on(Act::CancelSolving, [this] { workbench_.cancel_solving(); });
  actions_.on(Act::ResetPose, [this] { workbench_.apply(ResetPose{0}); });
}

void WorkbenchActions::connect_view() {
  connect_toggle(Act::ShowMeshes, &ViewState::show_meshes);
  connect_toggle(Act::ShowFill, &ViewState::show_fill);
  connect_toggle(Act::ShowField, &ViewState::show_field);
  connect_toggle(Act::ShowAxes, &ViewState::show_axes);
  connect_toggle(Act::Annotations, &ViewState::show_annotations);
  connect_toggle(Act::Names, &ViewState::show_names);
  connect_toggle(Act::Slices3d, &ViewState::show_slices_3d);
  connect_toggle(Act::Brush3d, &ViewState::brush_3d);
  connect_toggle(Act::Lasso, &ViewState::lasso);
  connect_toggle(Act::SmartBrush, &ViewState::smart_brush);
  connect_toggle(Act::LocalMarks, &ViewState::local_marks);
  connect_toggle(Act::WindowLevel, &ViewState::window_level_armed);
  actions_.on_toggle(Act::Neurological, [this](bool checked) {
    workbench_.view.convention = checked ? Convention::Neurological : Convention::Radiological;
    workbench_.view_edited();
  });
  actions_.on(Act::LessOpaque, [this] { change_opacity(-0.1f); });
  actions_.on(Act::MoreOpaque, [this] { change_opacity(0.1f); });
  actions_.on(Act::AutoContrast, [this] { workbench_.set_automatic_contrast(); });
  actions_.on(Act::Fit, [this] { views_.fit(); });
  actions_.on(Act::CentreOnCrosshair, [this] { views_.centre_on_crosshair(); });
}

void WorkbenchActions::connect_toggle(Act act, bool ViewState::*member) {
  actions_.on_toggle(act, [this, member](bool checked) {
    workbench_.view.*member = checked;
    workbench_.view_edited();
  });
  actions_[act]->setChecked(workbench_.view.*member);
}

int WorkbenchActions::place_of_active() const {
  const std::vector<MeshItem>& meshes = workbench_.scene().meshes;
  for (std::size_t m = 0; m < meshes.size(); ++m)
    if (meshes[m].id == workbench_.view.active_mesh) return static_cast<int>(m);
  return -1;
}

void WorkbenchActions::move_mesh(int by) {
  const int place = place_of_active();
  if (place >= 0) workbench_.apply(ReorderMesh{workbench_.view.active_mesh, place + by});
}

void WorkbenchActions::change_opacity(float by) {
  workbench_.view.opacity = std::clamp(workbench_.view.opacity + by, 0.1f, 1.0f);
  workbench_.view_edited();
}

void WorkbenchActions::refresh() {
  const Session& session = workbench_.session();
  name_history_entry(actions_[Act::Undo], tr("&Undo"), session.undo_title());
  name_history_entry(actions_[Act::Redo], tr("&Redo"), session.redo_title());
  set_enabled(actions_[Act::Undo], session.can_undo(), tr("There is nothing to undo"));
  set_enabled(actions_[Act::Redo], session.can_redo(), tr("There is nothing to redo"));
  const bool meshes = !workbench_.scene().meshes.empty();
  const QString no_mesh = why_no_mesh();
  for (const Act act : {Act::RunPause, Act::Step, Act::ResetPose, Act::Compare})
    set_enabled(actions_[act], meshes, no_mesh);
  for (const Act act : {Act::RecordProfiles, Act::LockMesh, Act::DuplicateMesh, Act::NameMesh, Act::DeleteMesh})
    set_enabled(actions_[act], meshes, no_mesh);
  const MeshItem* active = workbench_.active_mesh();
  const bool locked = active && active->locked;
  for (const Act act : {Act::ResetMesh, Act::RefineMesh})
    set_enabled(actions_[act], active && !locked, locked ? why_locked() : no_mesh);
  for (const Act act : {Act::BoundaryHere, Act::InsideHere, Act::OutsideHere})
    set_enabled(actions_[act], active && !locked, locked ? why_locked() : no_mesh);
  const int place = place_of_active(), last = static_cast<int>(workbench_.scene().meshes.size()) - 1;
  set_enabled(actions_[Act::MeshUp], place > 0, meshes ? tr("It is already the first in the list") : no_mesh);
  set_enabled(actions_[Act::MeshDown], place >= 0 && place < last,
              meshes ? tr("It is already the last in the list") : no_mesh);
  actions_[Act::LockMesh]->setChecked(locked);
  refresh_run();
  refresh_solving();
  set_enabled(actions_[Act::DeletePoint],
              !workbench_.scene().points.empty() || !workbench_.scene().measurements.empty(),
              tr("There are no points or measurements yet"));
  const QString no_volume = tr("Open a volume first");
  for (const Act act : {Act::ToolRuler, Act::ToolAngle, Act::ToolEllipse, Act::ToolSeed, Act::ToolBox,
                        Act::AutoContrast, Act::Fit, Act::CentreOnCrosshair, Act::WindowLevel}) {
    set_enabled(actions_[act], workbench_.has_volume(), no_volume);
  }
  for (const Act act : {Act::ToolPoint, Act::ToolOutside, Act::ToolBrush, Act::ToolEraser, Act::ToolFreeze,
                        Act::ToolRange, Act::ShowField, Act::ShowAxes})
    set_enabled(actions_[act], meshes, no_mesh);
  refresh_inside_tool();
}

QString WorkbenchActions::why_no_mesh() {
  return tr("There is no segmentation yet: add one in the panel Segmentations, or with the tool Seed (%1)")
      .arg(key_hint(Act::ToolSeed));
}

// A lasso of this tool starts a segmentation if there is none.
void WorkbenchActions::refresh_inside_tool() {
  const bool starts = workbench_.view.lasso && workbench_.has_volume();
  set_enabled(actions_[Act::ToolInside], starts || !workbench_.scene().meshes.empty(), why_no_mesh());
}

void WorkbenchActions::refresh_run() {
  const bool moving = is_moving(workbench_, loop_);
  QAction* const action = actions_[Act::RunPause];
  action->setChecked(moving);
  if (std::exchange(shows_pause_, moving) == moving) return;
  action->setText(moving ? tr("&Pause") : tr("&Run"));
  action->setIcon(icon_of(moving ? Symbol::Pause : Symbol::Run, Qt::white));
}

void WorkbenchActions::refresh_solving() {
  set_enabled(actions_[Act::CancelSolving], workbench_.session().solving_mesh() != 0,
              tr("No segmentation is being solved"));
}

void WorkbenchActions::refresh_toggles() {
  refresh_inside_tool();
  set_enabled(actions_[Act::PointHere], workbench_.view.selected_point != 0, tr("No point is selected"));
  for (const auto& [act, tool] : kTools) actions_[act]->setChecked(workbench_.view.tool == tool);
  actions_[Act::WindowLevel]->setChecked(workbench_.view.window_level_armed);
  actions_[Act::ShowAxes]->setChecked(workbench_.view.show_axes);
}

}  // namespace simplexseg
