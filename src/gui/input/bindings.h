// SPDX-License-Identifier: Apache-2.0
// Table of key and mouse bindings, used by the menus, the views and the help.
#pragma once
#include <QObject>
#include <Qt>
#include <optional>
#include <span>

class QKeyEvent;

namespace simplexseg {

Q_NAMESPACE

// clang-format off
enum class Act {
  Open, OpenFolder, Archive, SendBack, OpenReference, SaveScene, SaveSceneAs, SaveLabels, SaveMeshes, SaveMeasurements, FollowStudy, FollowTimePoints, Screenshot, Quit,
  Undo, Redo, History, DeletePoint, BoundaryHere, InsideHere, OutsideHere, PointHere,
  ToolCrosshair, ToolZoomPan, ToolPoint, ToolSeed, ToolInside, ToolOutside, ToolBox, ToolBrush, ToolEraser, ToolFreeze, Brush3d, Lasso, SmartBrush, LocalMarks, ToolRuler, ToolAngle, ToolEllipse, ToolRange,
  RunPause, Step, CancelSolving, ResetPose, Compare,
  ResetMesh, RefineMesh, RecordProfiles, LockMesh, DuplicateMesh, NameMesh, MeshUp, MeshDown, DeleteMesh, NetworkStart, MeshFromLabels, MeshFromFile, WorstFit,
  ShowMeshes, ShowFill, ShowField, ShowAxes, LessOpaque, MoreOpaque, Annotations, Names, Slices3d, Neurological, CentreOnCrosshair, Fit, AutoContrast, WindowLevel,
  ClipAxial, ClipSagittal, ClipCoronal, ClipFree, FlipAxial, FlipSagittal, FlipCoronal, FlipFree, FaceFreePlane, ImageOnCaps, VolumeShaded, VolumeMaximum,
  AddLayer, AddLayerFolder, RegisterLayer, FilterLayer, FilterVolume, LoadTransform, SaveTransform, RemoveLayer, LayerContrast, LayerBlend, LayerCheckerboard, LayerSwipe, ShowLayers,
  ShowPanels, ShowSteps, Researcher,
  Help, ChangeKeys, Messages, About,
  CrosshairLeft, CrosshairRight, CrosshairUp, CrosshairDown, CrosshairLeft5, CrosshairRight5, CrosshairUp5, CrosshairDown5, NextSlice, PreviousSlice,
  MoveCrosshair, AddPoint, AddInside, AddOutside, ErasePoint, PickMesh, ContextMenu, Zoom, Pan, WheelSlice, WheelZoom, BrushSize, PointReach, PointStrength, FollowMouse, Maximise, Rotate
};
Q_ENUM_NS(Act)  // files of keys contain the names
// clang-format on

/// Scope of a binding. Bindings of scope Everywhere are menu entries.
enum class Where { Everywhere, Slices, Space };
/// Mouse gesture. WheelOnPoint: the wheel while a point is under the mouse.
enum class Mouse { None, Left, Right, Middle, RightClick, DoubleClick, Wheel, WheelOnPoint, Move };

struct Binding {
  Act act;
  Where where;
  const char* keys;  ///< default key in the syntax of QKeySequence; "" for mouse gestures
  Mouse mouse;
  Qt::KeyboardModifiers modifiers;  ///< keys held during the mouse gesture
  const char* title;                ///< text of the menu entry; "" if there is none
  const char* help;                 ///< one line for the help and the tooltip
};
std::span<const Binding> bindings();

/// First binding of `act`; every act has one.
const Binding& binding_of(Act act);
/// Heading of the scope in the help.
const char* where_name(Where where);
/// Act bound to a mouse gesture, or to a key (KeyMap) in a scope; none if nothing is bound.
std::optional<Act> gesture(Where where, Mouse mouse, Qt::KeyboardModifiers modifiers);
std::optional<Act> key_in(Where where, const QKeyEvent& event);

}  // namespace simplexseg
