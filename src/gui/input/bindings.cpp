// SPDX-License-Identifier: Apache-2.0
#include "gui/input/bindings.h"

#include <QKeyEvent>
#include <QKeySequence>
#include <algorithm>

namespace simplexseg {
namespace {

constexpr auto kEverywhere = Where::Everywhere;
constexpr auto kSlices = Where::Slices;
constexpr auto kSpace = Where::Space;

// clang-format off
const Binding kBindings[] = {
    {Act::MoveCrosshair, kSlices, "", Mouse::Left, {}, "",
     "On a point: drag it; on the active mesh's outline: pull it; elsewhere: move the crosshair"},
    {Act::AddPoint, kSlices, "", Mouse::Left, Qt::ShiftModifier, "",
     "Add a boundary point to the active mesh, whose surface it attracts; placed on press, final on release"},
    {Act::AddInside, kSlices, "I", Mouse::None, {}, "", "Add an inside point under the mouse: the place belongs to the object"},
    {Act::AddOutside, kSlices, "O", Mouse::None, {}, "", "Add an outside point under the mouse: the place does not belong to it"},
    {Act::ErasePoint, kSlices, "", Mouse::Left, Qt::AltModifier, "", "Delete the point under the cursor"},
    {Act::ErasePoint, kSlices, "", Mouse::Left, Qt::ControlModifier | Qt::ShiftModifier, "",
     "Delete the point under the cursor, where the desktop keeps Alt to itself"},
    {Act::PickMesh, kSlices, "", Mouse::Left, Qt::ControlModifier, "", "Make the mesh under the cursor active"},
    {Act::ContextMenu, kSlices, "", Mouse::RightClick, {}, "", "Menu: add or delete a point, make a mesh active"},
    {Act::Zoom, kSlices, "", Mouse::Right, {}, "", "Zoom"},
    {Act::Pan, kSlices, "", Mouse::Middle, {}, "", "Pan"},
    {Act::WheelSlice, kSlices, "", Mouse::Wheel, {}, "", "Next or previous slice"},
    {Act::WheelZoom, kSlices, "", Mouse::Wheel, Qt::ControlModifier, "", "Zoom about the cursor"},
    {Act::PointReach, kSlices, "", Mouse::WheelOnPoint, {}, "",
     "Reach: of an inside or outside point the ball that it marks; of a boundary point how far around the surface follows"},
    {Act::PointStrength, kSlices, "", Mouse::WheelOnPoint, Qt::ShiftModifier, "", "Strength of a boundary point's pull"},
    {Act::FollowMouse, kSlices, "", Mouse::Move, Qt::ShiftModifier, "", "The crosshair follows in all views"},
    {Act::Maximise, kSlices, "", Mouse::DoubleClick, {}, "", "Maximise the view, and back"},
    {Act::CrosshairLeft, kSlices, "Left", Mouse::None, {}, "", "Crosshair one voxel to the left"},
    {Act::CrosshairRight, kSlices, "Right", Mouse::None, {}, "", "Crosshair one voxel to the right"},
    {Act::CrosshairUp, kSlices, "Up", Mouse::None, {}, "", "Crosshair one voxel up"},
    {Act::CrosshairDown, kSlices, "Down", Mouse::None, {}, "", "Crosshair one voxel down"},
    {Act::CrosshairLeft5, kSlices, "Shift+Left", Mouse::None, {}, "", "Crosshair five voxels to the left"},
    {Act::CrosshairRight5, kSlices, "Shift+Right", Mouse::None, {}, "", "Crosshair five voxels to the right"},
    {Act::CrosshairUp5, kSlices, "Shift+Up", Mouse::None, {}, "", "Crosshair five voxels up"},
    {Act::CrosshairDown5, kSlices, "Shift+Down", Mouse::None, {}, "", "Crosshair five voxels down"},
    {Act::NextSlice, kSlices, "PgUp", Mouse::None, {}, "", "Next slice"},
    {Act::PreviousSlice, kSlices, "PgDown", Mouse::None, {}, "", "Previous slice"},

    {Act::Rotate, kSpace, "", Mouse::Left, {}, "", "On a point: select it, or drag it along the screen; elsewhere: rotate"},
    {Act::PointReach, kSpace, "", Mouse::WheelOnPoint, {}, "", "Reach of the point, as in slices"},
    {Act::PointStrength, kSpace, "", Mouse::WheelOnPoint, Qt::ShiftModifier, "", "Strength of a boundary point's pull"},
    {Act::Pan, kSpace, "", Mouse::Left, Qt::ShiftModifier, "", "Pan"},
    {Act::Pan, kSpace, "", Mouse::Middle, {}, "", "Pan"},
    {Act::Zoom, kSpace, "", Mouse::Right, {}, "", "Zoom"},
    {Act::WheelZoom, kSpace, "", Mouse::Wheel, {}, "", "Zoom"},
    {Act::PickMesh, kSpace, "", Mouse::Left, Qt::ControlModifier, "", "Make the mesh under the cursor active"},
    {Act::Maximise, kSpace, "", Mouse::DoubleClick, {}, "", "Maximise the view, and back"},

    {Act::Open, kEverywhere, "Ctrl+O", Mouse::None, {}, "&Open...", "Open a volume or a scene"},
    {Act::OpenFolder, kEverywhere, "Ctrl+Shift+O", Mouse::None, {}, "Open &DICOM folder...", "Open a DICOM series"},
    {Act::Archive, kEverywhere, "Ctrl+Shift+A", Mouse::None, {}, "Archi&ve...", "Find a series in an archive (PACS), fetch and open it"},
    {Act::SendBack, kEverywhere, "Ctrl+Shift+B", Mouse::None, {}, "Send &back to archive...",
     "Send labels, contours and a picture into the study that the image is of"},
    {Act::OpenReference, kEverywhere, "Ctrl+Shift+L", Mouse::None, {}, "Load re&ference labels...",
     "Labels that the meshes are compared with in the panel Check"},
    {Act::SaveScene, kEverywhere, "Ctrl+S", Mouse::None, {}, "&Save scene", "Save the scene with its meshes and points"},
    {Act::SaveSceneAs, kEverywhere, "Ctrl+Shift+S", Mouse::None, {}, "Save scene &as...", "Save the scene to a new file"},
    {Act::SaveLabels, kEverywhere, "Ctrl+L", Mouse::None, {}, "Save &labels...",
     "Save the voxels inside the meshes as a label volume"},
    {Act::SaveMeshes, kEverywhere, "Ctrl+M", Mouse::None, {}, "Save &meshes...", "Save each mesh into a folder (PLY, OBJ, STL, VTK or VTP, in LPS)"},
    {Act::Screenshot, kEverywhere, "Ctrl+P", Mouse::None, {}, "Sc&reenshot...", "Save a picture of the window"},
    {Act::Quit, kEverywhere, "Ctrl+Q", Mouse::None, {}, "&Quit", "Leave the program"},
    {Act::Undo, kEverywhere, "Ctrl+Z", Mouse::None, {}, "&Undo", "Undo the last action"},
    {Act::Redo, kEverywhere, "Ctrl+Shift+Z", Mouse::None, {}, "&Redo", "Do again what was undone"},
    {Act::History, kEverywhere, "Ctrl+H", Mouse::None, {}, "&History", "The list of what was done; a click goes there"},
    {Act::DeletePoint, kEverywhere, "Del", Mouse::None, {}, "&Delete point",
     "Delete the point under the cursor, or else the selected one"},
    {Act::BoundaryHere, kEverywhere, "Shift+B", Mouse::None, {}, "&Boundary point at crosshair",
     "Add a boundary point to the active mesh where the crosshair is"},
    {Act::InsideHere, kEverywhere, "Shift+I", Mouse::None, {}, "&Inside point at crosshair",
     "Add an inside point to the active mesh where the crosshair is"},
    {Act::OutsideHere, kEverywhere, "Shift+O", Mouse::None, {}, "&Outside point at crosshair",
     "Add an outside point to the active mesh where the crosshair is"},
    {Act::PointHere, kEverywhere, "Shift+M", Mouse::None, {}, "&Move point to crosshair",
     "Move the selected point to where the crosshair is"},
    {Act::ToolCrosshair, kEverywhere, "1", Mouse::None, {}, "&Crosshair", "Tool: left drag moves the crosshair"},
    {Act::ToolZoomPan, kEverywhere, "2", Mouse::None, {}, "&Zoom and pan", "Tool: left drag pans, right drag zooms"},
    {Act::ToolPoint, kEverywhere, "3", Mouse::None, {}, "Boundary &point", "Tool: left button adds or drags a boundary point"},
    {Act::ToolSeed, kEverywhere, "4", Mouse::None, {}, "&New mesh", "Tool: left drag places a sphere, centre to radius"},
    {Act::ToolInside, kEverywhere, "5", Mouse::None, {}, "&Inside point",
     "Tool: left button adds a point that belongs to the object, or drags one"},
    {Act::ToolOutside, kEverywhere, "6", Mouse::None, {}, "&Outside point",
     "Tool: left button adds a point that does not belong to the object, or drags one"},
    {Act::WindowLevel, kEverywhere, "W", Mouse::None, {}, "&Window and level",
     "Then left drag: window (sideways) and level (up and down)"},
    {Act::RunPause, kEverywhere, "Space", Mouse::None, {}, "&Run", "Run or pause the simulation"},
    {Act::Step, kEverywhere, ".", Mouse::None, {}, "&One step", "One step of the simulation"},
    {Act::ResetPose, kEverywhere, "R", Mouse::None, {}, "Re&set all meshes", "Every mesh back to its sphere"},
    {Act::Compare, kEverywhere, "Ctrl+Shift+C", Mouse::None, {}, "&Compare settings...",
     "Two settings of the active mesh from the same start, beside each other"},
    {Act::ResetMesh, kEverywhere, "Ctrl+R", Mouse::None, {}, "&Reset", "The active mesh back to its sphere"},
    {Act::RefineMesh, kEverywhere, "Ctrl+E", Mouse::None, {}, "Re&fine", "Four times as many vertices for the active mesh"},
    {Act::RecordProfiles, kEverywhere, "Ctrl+Shift+P", Mouse::None, {}, "Record &profiles",
     "Take the intensities under the present pose as what the force Intensity profile looks for"},
    {Act::LockMesh, kEverywhere, "L", Mouse::None, {}, "&Lock", "The active mesh keeps its pose, whatever happens to others"},
    {Act::DuplicateMesh, kEverywhere, "Ctrl+D", Mouse::None, {}, "D&uplicate",
     "A copy of the active mesh with its points, to try other settings on"},
    {Act::MeshUp, kEverywhere, "Ctrl+Shift+Up", Mouse::None, {}, "Mo&ve up", "The active mesh one place up in the list"},
    {Act::MeshDown, kEverywhere, "Ctrl+Shift+Down", Mouse::None, {}, "Move do&wn", "The active mesh one place down in the list"},
    {Act::DeleteMesh, kEverywhere, "Ctrl+Del", Mouse::None, {}, "&Delete", "Delete the active mesh and its points"},
    {Act::MeshFromLabels, kEverywhere, "Ctrl+Shift+E", Mouse::None, {}, "Meshes from l&abels...",
     "Labels of a volume become meshes"},
    {Act::MeshFromFile, kEverywhere, "Ctrl+Shift+F", Mouse::None, {}, "Mesh from a &file...",
     "A closed surface of another program (STL, OBJ, VTK, VTP, PLY) becomes a mesh"},
    {Act::WorstFit, kEverywhere, "G", Mouse::None, {}, "&Go to the worst fit",
     "The crosshair goes to where the active mesh fits worst: its reference, or else the image; again: the next place"},
    {Act::ShowMeshes, kEverywhere, "S", Mouse::None, {}, "&Meshes", "Show or hide the meshes"},
    {Act::ShowFill, kEverywhere, "Shift+S", Mouse::None, {}, "F&ill", "Fill the meshes in the slices, or show their outlines alone"},
    {Act::ShowField, kEverywhere, "F", Mouse::None, {}, "&Field of the active mesh",
     "Show or hide in the slices what the active mesh has learned of its object"},
    {Act::LessOpaque, kEverywhere, "A", Mouse::None, {}, "&Less opaque", "Meshes in 3D and their fill in slices more transparent"},
    {Act::MoreOpaque, kEverywhere, "D", Mouse::None, {}, "&More opaque", "Meshes in 3D and their fill in slices less transparent"},
    {Act::Annotations, kEverywhere, "X", Mouse::None, {}, "&Annotations", "Show or hide crosshair and texts"},
    {Act::Names, kEverywhere, "Shift+N", Mouse::None, {}, "&Patient and series",
     "Show or hide the names of patient and series, for pictures"},
    {Act::Slices3d, kEverywhere, "Shift+X", Mouse::None, {}, "&Slices in 3D", "Show or hide the slices in the 3D view"},
    {Act::Neurological, kEverywhere, "Ctrl+Shift+N", Mouse::None, {}, "&Neurological convention",
     "The patient's left on the left of the screen"},
    {Act::CentreOnCrosshair, kEverywhere, "C", Mouse::None, {}, "&Centre on crosshair", "Centre all views on the crosshair"},
    {Act::Fit, kEverywhere, "Ctrl+F", Mouse::None, {}, "&Fit", "The whole volume in all views"},
    {Act::AutoContrast, kEverywhere, "Ctrl+J", Mouse::None, {}, "Automatic &contrast", "Window and level from the volume"},
    {Act::ShowPanels, kEverywhere, "F4", Mouse::None, {}, "&Panels", "Show or hide the panels beside the views"},
    {Act::ShowSteps, kEverywhere, "F3", Mouse::None, {}, "&Steps", "Show or hide the line with the next step: open, seed, correct"},
    {Act::Researcher, kEverywhere, "Ctrl+Shift+R", Mouse::None, {}, "&Researcher's layout",
     "With the panels Plan and Convergence: what a step computes and how near the meshes are to their end"},
    {Act::Help, kEverywhere, "F1", Mouse::None, {}, "&Keys and gestures", "This table"},
    {Act::Messages, kEverywhere, "F2", Mouse::None, {}, "&Messages", "All messages of this run of the program"},
    {Act::About, kEverywhere, "Shift+F1", Mouse::None, {}, "&About SimplexSeg", "Version and backend"},
};
// clang-format on

}  // namespace

std::span<const Binding> bindings() { return kBindings; }

const Binding& binding_of(Act act) {
  return *std::find_if(std::begin(kBindings), std::end(kBindings), [&](const Binding& b) { return b.act == act; });
}

const char* where_name(Where where) {
  switch (where) {
    case Where::Everywhere:
      return "Everywhere";
    case Where::Slices:
      return "Slices";
    case Where::Space:
      break;
  }
  return "3D view";
}

std::optional<Act> gesture(Where where, Mouse mouse, Qt::KeyboardModifiers modifiers) {
  modifiers &= Qt::ShiftModifier | Qt::ControlModifier | Qt::AltModifier;
  for (const Binding& binding : kBindings) {
    if (binding.where == where && binding.mouse == mouse && mouse != Mouse::None && binding.modifiers == modifiers) {
      return binding.act;
    }
  }
  return std::nullopt;
}

std::optional<Act> key_in(Where where, const QKeyEvent& event) {
  const QKeySequence pressed(static_cast<int>(event.modifiers() & ~Qt::KeypadModifier) | event.key());
  for (const Binding& binding : kBindings) {
    if (binding.where == where && *binding.keys && QKeySequence(QString::fromLatin1(binding.keys)) == pressed) {
      return binding.act;
    }
  }
  return std::nullopt;
}

}  // namespace simplexseg
