// SPDX-License-Identifier: Apache-2.0
#include "gui/input/bindings.h"

#include <QKeyEvent>
#include <QKeySequence>
#include <algorithm>

#include "gui/input/key_map.h"

namespace simplexseg {
namespace {

constexpr auto kEverywhere = Where::Everywhere;
constexpr auto kSlices = Where::Slices;
constexpr auto kSpace = Where::Space;

// clang-format off
const Binding kBindings[] = {
    {Act::MoveCrosshair, kSlices, "", Mouse::Left, {}, "",
     "On a point or measurement: drag it; on the active contour: pull it; elsewhere: move the crosshair"},
    {Act::AddPoint, kSlices, "", Mouse::Left, Qt::ShiftModifier, "",
     "Add a boundary point that attracts the active surface; placed on press, final on release"},
    {Act::AddInside, kSlices, "I", Mouse::None, {}, "",
     "Mark what belongs to the structure: add an inside point under the mouse"},
    {Act::AddOutside, kSlices, "O", Mouse::None, {}, "",
     "Mark what does not belong to the structure: add an outside point under the mouse"},
    {Act::ErasePoint, kSlices, "", Mouse::Left, Qt::AltModifier, "", "Delete the point under the mouse"},
    {Act::ErasePoint, kSlices, "", Mouse::Left, Qt::ControlModifier | Qt::ShiftModifier, "",
     "Delete the point under the mouse, for desktops that reserve Alt"},
    {Act::PickMesh, kSlices, "", Mouse::Left, Qt::ControlModifier, "", "Make the segmentation under the mouse active"},
    {Act::ContextMenu, kSlices, "", Mouse::RightClick, {}, "",
     "Menu: add or delete a point, rename or delete a measurement, make a segmentation active"},
    {Act::Zoom, kSlices, "", Mouse::Right, {}, "", "Zoom"},
    {Act::Pan, kSlices, "", Mouse::Middle, {}, "", "Pan"},
    {Act::WheelSlice, kSlices, "", Mouse::Wheel, {}, "", "Next or previous slice"},
    {Act::WheelZoom, kSlices, "", Mouse::Wheel, Qt::ControlModifier, "", "Zoom about the mouse position"},
    {Act::BrushSize, kSlices, "", Mouse::Wheel, Qt::ShiftModifier, "", "Size of brush and eraser"},
    {Act::PointReach, kSlices, "", Mouse::WheelOnPoint, {}, "",
     "Reach of the point: radius of an inside or outside point; range of the surface that a boundary point pulls"},
    {Act::PointStrength, kSlices, "", Mouse::WheelOnPoint, Qt::ShiftModifier, "",
     "Strength with which a boundary point pulls"},
    {Act::FollowMouse, kSlices, "", Mouse::Move, Qt::ShiftModifier, "", "The crosshair follows the mouse"},
    {Act::Maximise, kSlices, "", Mouse::DoubleClick, {}, "", "Maximise or restore the view"},
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

    {Act::Rotate, kSpace, "", Mouse::Left, {}, "",
     "On a point: select it, or drag it parallel to the screen; on a handle of the free plane: move or tilt it; elsewhere: rotate"},
    {Act::PointReach, kSpace, "", Mouse::WheelOnPoint, {}, "", "Reach of the point, as in slices"},
    {Act::PointStrength, kSpace, "", Mouse::WheelOnPoint, Qt::ShiftModifier, "", "Strength with which a boundary point pulls"},
    {Act::Pan, kSpace, "", Mouse::Left, Qt::ShiftModifier, "", "Pan"},
    {Act::Pan, kSpace, "", Mouse::Middle, {}, "", "Pan"},
    {Act::Zoom, kSpace, "", Mouse::Right, {}, "", "Zoom"},
    {Act::WheelZoom, kSpace, "", Mouse::Wheel, {}, "", "Zoom"},
    {Act::PickMesh, kSpace, "", Mouse::Left, Qt::ControlModifier, "", "Make the segmentation under the mouse active"},
    {Act::Maximise, kSpace, "", Mouse::DoubleClick, {}, "", "Maximise or restore the view"},

    {Act::Open, kEverywhere, "Ctrl+O", Mouse::None, {}, "&Open...", "Open a volume or a scene"},
    {Act::OpenFolder, kEverywhere, "Ctrl+Shift+O", Mouse::None, {}, "Open &DICOM folder...", "Open a DICOM series"},
    {Act::Archive, kEverywhere, "Ctrl+Shift+A", Mouse::None, {}, "Archi&ve...",
     "Find, fetch and open a series of an archive (PACS)"},
    {Act::SendBack, kEverywhere, "Ctrl+Shift+B", Mouse::None, {}, "Send &back to archive...",
     "Send labels, contours, a report and a picture to the study of the image"},
    {Act::OpenReference, kEverywhere, "Ctrl+Shift+L", Mouse::None, {}, "Load re&ference labels...",
     "Load labels with which the panel Check compares the segmentations"},
    {Act::SaveScene, kEverywhere, "Ctrl+S", Mouse::None, {}, "&Save scene",
     "Save the scene with its segmentations and points"},
    {Act::SaveSceneAs, kEverywhere, "Ctrl+Shift+S", Mouse::None, {}, "Save scene &as...",
     "Save the scene to a new file"},
    {Act::SaveLabels, kEverywhere, "Ctrl+L", Mouse::None, {}, "Save &labels...",
     "Save the segmentations as a label volume"},
    {Act::SaveMeshes, kEverywhere, "Ctrl+M", Mouse::None, {}, "Save s&urfaces...",
     "Save the surface of each segmentation to a folder (PLY, OBJ, STL, VTK or VTP, in LPS)"},
    {Act::SaveMeasurements, kEverywhere, "Ctrl+Shift+M", Mouse::None, {}, "Save &measurements...",
     "Save a table (CSV) of all rulers, angles and ellipses, and of volume, long and short axis of each segmentation"},
    {Act::FollowStudy, kEverywhere, "Ctrl+U", Mouse::None, {}, "&Carry over to the next study...",
     "Carry surfaces, marks and locks over to another study of the patient, and compare the volumes"},
    {Act::FollowTimePoints, kEverywhere, "Ctrl+Shift+J", Mouse::None, {}, "Follow &time points...",
     "Carry the segmentations through the volumes of a 4D image, and show the course of their volumes"},
    {Act::Screenshot, kEverywhere, "Ctrl+P", Mouse::None, {}, "Sc&reenshot...", "Save a picture of the window"},
    {Act::Quit, kEverywhere, "Ctrl+Q", Mouse::None, {}, "&Quit", "Close the program"},
    {Act::Undo, kEverywhere, "Ctrl+Z", Mouse::None, {}, "&Undo", "Undo the last action"},
    {Act::Redo, kEverywhere, "Ctrl+Shift+Z", Mouse::None, {}, "&Redo", "Redo the last undone action"},
    {Act::History, kEverywhere, "Ctrl+H", Mouse::None, {}, "&History",
     "List of all actions; click one to return to it"},
    {Act::DeletePoint, kEverywhere, "Del", Mouse::None, {}, "&Delete point or measurement",
     "Delete the point or measurement under the mouse, otherwise the selected one"},
    {Act::BoundaryHere, kEverywhere, "Shift+B", Mouse::None, {}, "&Boundary point at crosshair",
     "Add a boundary point to the active segmentation at the crosshair"},
    {Act::InsideHere, kEverywhere, "Shift+I", Mouse::None, {}, "&Inside point at crosshair",
     "Add an inside point to the active segmentation at the crosshair"},
    {Act::OutsideHere, kEverywhere, "Shift+O", Mouse::None, {}, "&Outside point at crosshair",
     "Add an outside point to the active segmentation at the crosshair"},
    {Act::PointHere, kEverywhere, "Shift+M", Mouse::None, {}, "&Move point to crosshair",
     "Move the selected point to the crosshair"},
    {Act::ToolCrosshair, kEverywhere, "1", Mouse::None, {}, "&Crosshair", "Tool: left drag moves the crosshair"},
    {Act::ToolZoomPan, kEverywhere, "2", Mouse::None, {}, "&Zoom and pan", "Tool: left drag pans, right drag zooms"},
    {Act::ToolPoint, kEverywhere, "3", Mouse::None, {}, "Boundary &point",
     "Tool: left button adds or drags a boundary point"},
    {Act::ToolSeed, kEverywhere, "4", Mouse::None, {}, "&New segmentation",
     "Tool: left drag from the centre of the structure to its edge places a seed sphere"},
    {Act::ToolInside, kEverywhere, "5", Mouse::None, {}, "&Inside point",
     "Tool: a click marks what belongs to the structure, a drag draws an inside stroke or moves a point"},
    {Act::ToolOutside, kEverywhere, "6", Mouse::None, {}, "&Outside point",
     "Tool: a click marks what does not belong to the structure, a drag draws an outside stroke or moves a point"},
    {Act::ToolBox, kEverywhere, "7", Mouse::None, {}, "New segmentation from a bo&x",
     "Tool: left drag draws a box around the structure in a slice, or with Lasso a contour; a segmentation starts from it"},
    {Act::ToolBrush, kEverywhere, "B", Mouse::None, {}, "Pa&int",
     "Tool: paint voxels, which belong to the structure from then on"},
    {Act::ToolEraser, kEverywhere, "E", Mouse::None, {}, "&Erase",
     "Tool: erase voxels, which do not belong to the structure from then on"},
    {Act::ToolFreeze, kEverywhere, "K", Mouse::None, {}, "&Freeze",
     "Tool: keep the part under the brush as it is, whatever is marked later"},
    {Act::Brush3d, kEverywhere, "T", Mouse::None, {}, "Brush in &three dimensions",
     "The brush is a ball, and the lasso cuts through the volume; otherwise both act in the slice"},
    {Act::Lasso, kEverywhere, "Q", Mouse::None, {}, "&Lasso",
     "Paint, erase, freeze and mark what a drag encloses, instead of what lies under it; the tool of the box starts from it"},
    {Act::SmartBrush, kEverywhere, "Y", Mouse::None, {}, "Stop at ed&ges",
     "Paint and erase only voxels with the intensities along the stroke"},
    {Act::LocalMarks, kEverywhere, "J", Mouse::None, {}, "Correct only near &marks",
     "Points, strokes and lassos from now on change the segmentation only near them, and nothing far away"},
    {Act::ToolRuler, kEverywhere, "8", Mouse::None, {}, "&Ruler",
     "Tool: left drag measures a distance; drag an end or the line of a ruler to move it"},
    {Act::ToolAngle, kEverywhere, "9", Mouse::None, {}, "An&gle",
     "Tool: three clicks measure an angle: end of a leg, vertex, end of the other leg"},
    {Act::ToolEllipse, kEverywhere, "0", Mouse::None, {}, "E&llipse",
     "Tool: left drag draws an ellipse and measures its area and the intensities in it"},
    {Act::ToolRange, kEverywhere, "H", Mouse::None, {}, "Range of in&tensities",
     "Tool: left drag over tissue limits the active segmentation to the intensities in the rectangle"},
    {Act::WindowLevel, kEverywhere, "W", Mouse::None, {}, "&Window and level",
     "The next left drag changes the window (left, right) and the level (up, down)"},
    {Act::RunPause, kEverywhere, "Space", Mouse::None, {}, "&Run", "Run or pause the segmentation"},
    {Act::Step, kEverywhere, ".", Mouse::None, {}, "&One step", "Advance by a single step"},
    {Act::CancelSolving, kEverywhere, "Esc", Mouse::None, {}, "Ca&ncel solving",
     "Cancel the measurement that is being drawn; otherwise the update of the segmentation that is being solved; it remains as before the last mark"},
    {Act::ResetPose, kEverywhere, "R", Mouse::None, {}, "Re&set all segmentations",
     "Reset every segmentation to its start"},
    {Act::Compare, kEverywhere, "Ctrl+Shift+C", Mouse::None, {}, "&Compare settings...",
     "Compare two settings for the active segmentation side by side, from the same start"},
    {Act::ResetMesh, kEverywhere, "Ctrl+R", Mouse::None, {}, "&Reset", "Reset the active segmentation to its start"},
    {Act::RefineMesh, kEverywhere, "Ctrl+E", Mouse::None, {}, "Re&fine",
     "Refine the surface of the active segmentation: four times as many vertices"},
    {Act::RecordProfiles, kEverywhere, "Ctrl+Shift+P", Mouse::None, {}, "Record &profiles",
     "Record the intensities at the current surface as the reference of the force Intensity profile"},
    {Act::LockMesh, kEverywhere, "L", Mouse::None, {}, "&Lock", "Protect the active segmentation from any change"},
    {Act::DuplicateMesh, kEverywhere, "Ctrl+D", Mouse::None, {}, "D&uplicate",
     "Copy the active segmentation with its points, to try other settings"},
    {Act::NameMesh, kEverywhere, "N", Mouse::None, {}, "&Name...",
     "Name the active segmentation: two letters suggest structures with their colour, label and DICOM code"},
    {Act::MeshUp, kEverywhere, "Ctrl+Shift+Up", Mouse::None, {}, "Mo&ve up",
     "Move the active segmentation one place up in the list"},
    {Act::MeshDown, kEverywhere, "Ctrl+Shift+Down", Mouse::None, {}, "Move do&wn",
     "Move the active segmentation one place down in the list"},
    {Act::DeleteMesh, kEverywhere, "Ctrl+Del", Mouse::None, {}, "&Delete",
     "Delete the active segmentation and its points"},
    {Act::NetworkStart, kEverywhere, "Ctrl+N", Mouse::None, {}, "&Start from a network...",
     "Start the active segmentation from the mask of a network on a server, to which the image is then sent"},
    {Act::MeshFromLabels, kEverywhere, "Ctrl+Shift+E", Mouse::None, {}, "Segmentations from l&abels...",
     "Load labels of a label volume or of DICOM contours as segmentations"},
    {Act::MeshFromFile, kEverywhere, "Ctrl+Shift+F", Mouse::None, {}, "Segmentation from a &file...",
     "Load a closed surface of another program (STL, OBJ, VTK, VTP, PLY) as a segmentation"},
    {Act::WorstFit, kEverywhere, "G", Mouse::None, {}, "&Go to the worst fit",
     "Move the crosshair to the place where the active segmentation fits its reference or the image worst; again: the next"},
    {Act::ShowMeshes, kEverywhere, "S", Mouse::None, {}, "&Segmentations", "Show or hide the segmentations"},
    {Act::ShowFill, kEverywhere, "Shift+S", Mouse::None, {}, "F&ill",
     "Show the segmentations in slices filled, or as contours only"},
    {Act::ShowField, kEverywhere, "F", Mouse::None, {}, "Probability &field",
     "Show or hide the foreground probability of the active segmentation in the slices"},
    {Act::ShowAxes, kEverywhere, "Shift+D", Mouse::None, {}, "Long and short a&xis",
     "Show the long and the short axis of each segmentation (RECIST 1.1) in the slice in which they lie"},
    {Act::LessOpaque, kEverywhere, "A", Mouse::None, {}, "&Less opaque",
     "Make surfaces in 3D and fill in slices more transparent"},
    {Act::MoreOpaque, kEverywhere, "D", Mouse::None, {}, "&More opaque",
     "Make surfaces in 3D and fill in slices less transparent"},
    {Act::Annotations, kEverywhere, "X", Mouse::None, {}, "&Annotations", "Show or hide crosshair and annotations"},
    {Act::Names, kEverywhere, "Shift+N", Mouse::None, {}, "&Patient and series",
     "Show or hide patient and series names, for anonymous pictures"},
    {Act::Slices3d, kEverywhere, "Shift+X", Mouse::None, {}, "&Slices in 3D", "Show or hide the slices in the 3D view"},
    {Act::Neurological, kEverywhere, "Ctrl+Shift+N", Mouse::None, {}, "&Neurological convention",
     "Show the patient's left on the left of the screen"},
    {Act::CentreOnCrosshair, kEverywhere, "C", Mouse::None, {}, "&Centre on crosshair",
     "Centre all views on the crosshair"},
    {Act::Fit, kEverywhere, "Ctrl+F", Mouse::None, {}, "&Fit", "Fit the whole volume into all views"},
    {Act::AutoContrast, kEverywhere, "Ctrl+J", Mouse::None, {}, "Automatic &contrast",
     "Set window and level from the volume"},
    {Act::ClipAxial, kEverywhere, "F5", Mouse::None, {}, "&Axial plane",
     "Cut the 3D view at the axial slice"},
    {Act::ClipSagittal, kEverywhere, "F6", Mouse::None, {}, "&Sagittal plane",
     "Cut the 3D view at the sagittal slice"},
    {Act::ClipCoronal, kEverywhere, "F7", Mouse::None, {}, "&Coronal plane",
     "Cut the 3D view at the coronal slice"},
    {Act::ClipFree, kEverywhere, "F8", Mouse::None, {}, "&Free plane",
     "Cut the 3D view at a plane that is moved by its arrow and tilted by its ring"},
    {Act::FlipAxial, kEverywhere, "Shift+F5", Mouse::None, {}, "Flip a&xial plane",
     "Remove the other side of the axial plane"},
    {Act::FlipSagittal, kEverywhere, "Shift+F6", Mouse::None, {}, "Flip sa&gittal plane",
     "Remove the other side of the sagittal plane"},
    {Act::FlipCoronal, kEverywhere, "Shift+F7", Mouse::None, {}, "Flip co&ronal plane",
     "Remove the other side of the coronal plane"},
    {Act::FlipFree, kEverywhere, "Shift+F8", Mouse::None, {}, "Fli&p free plane",
     "Remove the other side of the free plane"},
    {Act::FaceFreePlane, kEverywhere, "F9", Mouse::None, {}, "Free plane: facing the ca&mera",
     "Place the free plane at the crosshair, parallel to the screen"},
    {Act::ImageOnCaps, kEverywhere, "Shift+F9", Mouse::None, {}, "&Image on cut faces",
     "Show the image on cut faces, tinted by the colour of the segmentation, or this colour alone"},
    {Act::VolumeShaded, kEverywhere, "V", Mouse::None, {}, "&Shaded",
     "Show the volume in 3D with opacity from window and level, or hide it"},
    {Act::VolumeMaximum, kEverywhere, "Shift+V", Mouse::None, {}, "&Maximum intensity",
     "Show the largest intensity along each line of sight in 3D, or hide it"},
    {Act::AddLayer, kEverywhere, "Ctrl+Shift+I", Mouse::None, {}, "&Add layer...",
     "Show another image over the volume: another modality, contrast or date"},
    {Act::AddLayerFolder, kEverywhere, "Ctrl+I", Mouse::None, {}, "Add layer from &DICOM folder...",
     "Show the largest series of a DICOM folder over the volume"},
    {Act::RegisterLayer, kEverywhere, "Ctrl+Shift+G", Mouse::None, {}, "&Register layer...",
     "Find the transform that brings the active layer onto the volume"},
    {Act::FilterLayer, kEverywhere, "Ctrl+B", Mouse::None, {}, "&Filter layer...",
     "Apply a filter to the active layer: bias field correction, noise, thick slices; its file stays as it is"},
    {Act::FilterVolume, kEverywhere, "Ctrl+Shift+V", Mouse::None, {}, "Filter vol&ume...",
     "Apply a filter to the volume, which is then segmented with the filtered values; its file stays as it is"},
    {Act::LoadTransform, kEverywhere, "Ctrl+T", Mouse::None, {}, "&Load transform...",
     "Use a transform of ITK, ANTs, 3D Slicer or elastix for the active layer"},
    {Act::SaveTransform, kEverywhere, "Ctrl+Shift+T", Mouse::None, {}, "Sa&ve transform...",
     "Save the affine transform of the active layer as a file of ITK"},
    {Act::RemoveLayer, kEverywhere, "Ctrl+Shift+Del", Mouse::None, {}, "R&emove layer", "Remove the active layer"},
    {Act::LayerContrast, kEverywhere, "Shift+W", Mouse::None, {}, "&Window and level of the layer",
     "The next left drag changes the window (left, right) and the level (up, down) of the active layer"},
    {Act::LayerBlend, kEverywhere, "Shift+P", Mouse::None, {}, "&Blend", "Draw layers over the volume with their opacity"},
    {Act::LayerCheckerboard, kEverywhere, "P", Mouse::None, {}, "&Checkerboard",
     "Draw layers in every second square, the volume in the others"},
    {Act::LayerSwipe, kEverywhere, "U", Mouse::None, {}, "&Swipe",
     "Draw layers right of a divider, which can be dragged, and the volume left of it"},
    {Act::ShowLayers, kEverywhere, "M", Mouse::None, {}, "S&how layers", "Show or hide all layers"},
    {Act::ShowPanels, kEverywhere, "F4", Mouse::None, {}, "&Panels", "Show or hide the panels beside the views"},
    {Act::ShowSteps, kEverywhere, "F3", Mouse::None, {}, "&Steps",
     "Show or hide the guide to the next step: open, seed, correct"},
    {Act::Researcher, kEverywhere, "Ctrl+Shift+R", Mouse::None, {}, "&Researcher's layout",
     "Add forces, simulation, computations of a step, residuals, and the actions for them"},
    {Act::Help, kEverywhere, "F1", Mouse::None, {}, "&Keys and gestures", "Show this table"},
    {Act::ChangeKeys, kEverywhere, "Ctrl+K", Mouse::None, {}, "&Change keys...", "Give actions and tools other keys"},
    {Act::Messages, kEverywhere, "F2", Mouse::None, {}, "&Messages", "Show all messages since the program started"},
    {Act::About, kEverywhere, "Shift+F1", Mouse::None, {}, "&About SimplexSeg",
     "Show the version and the computing device"},
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
  const std::optional<Act> act = KeyMap::shared().keys().act_with(key_of_event(event));
  return act && binding_of(*act).where == where ? act : std::nullopt;
}

}  // namespace simplexseg
