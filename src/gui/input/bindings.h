// SPDX-License-Identifier: Apache-2.0
// The map of bindings: one table that makes the menus' shortcuts, tells the views what a gesture means, and is the
// help.
#pragma once
#include <Qt>
#include <optional>
#include <span>

class QKeyEvent;

namespace simplexseg {

// clang-format off
enum class Act {
  Open, OpenFolder, Archive, SendBack, OpenReference, SaveScene, SaveSceneAs, SaveLabels, SaveMeshes, Screenshot, Quit,
  Undo, Redo, History, DeletePoint, BoundaryHere, InsideHere, OutsideHere, PointHere,
  ToolCrosshair, ToolZoomPan, ToolPoint, ToolSeed, ToolInside, ToolOutside,
  RunPause, Step, ResetPose, Compare,
  ResetMesh, RefineMesh, RecordProfiles, LockMesh, DuplicateMesh, MeshUp, MeshDown, DeleteMesh, MeshFromLabels, MeshFromFile, WorstFit,
  ShowMeshes, ShowFill, ShowField, LessOpaque, MoreOpaque, Annotations, Names, Slices3d, Neurological, CentreOnCrosshair, Fit, AutoContrast, WindowLevel,
  ShowPanels, ShowSteps, Researcher,
  Help, Messages, About,
  CrosshairLeft, CrosshairRight, CrosshairUp, CrosshairDown, CrosshairLeft5, CrosshairRight5, CrosshairUp5, CrosshairDown5, NextSlice, PreviousSlice,
  MoveCrosshair, AddPoint, AddInside, AddOutside, ErasePoint, PickMesh, ContextMenu, Zoom, Pan, WheelSlice, WheelZoom, PointReach, PointStrength, FollowMouse, Maximise, Rotate
};
// clang-format on

/// Where a binding is valid. Those that are valid everywhere are menu entries.
enum class Where { Everywhere, Slices, Space };
/// WheelOnPoint: the wheel while a point is under the mouse.
enum class Mouse { None, Left, Right, Middle, RightClick, DoubleClick, Wheel, WheelOnPoint, Move };

struct Binding {
  Act act;
  Where where;
  const char* keys;  ///< as QKeySequence reads them; "" for the mouse
  Mouse mouse;
  Qt::KeyboardModifiers modifiers;  ///< the keys that are held with the mouse
  const char* title;                ///< text of the menu entry; "" when there is none
  const char* does;                 ///< one line for the help and the tooltip
};
std::span<const Binding> bindings();

/// The first binding of `act`; every act has one.
const Binding& binding_of(Act act);
/// The heading under which the help lists its bindings.
const char* where_name(Where where);
/// What a gesture of the mouse, or a key, means in a view; nothing when it is not bound there.
std::optional<Act> gesture(Where where, Mouse mouse, Qt::KeyboardModifiers modifiers);
std::optional<Act> key_in(Where where, const QKeyEvent& event);

}  // namespace simplexseg
