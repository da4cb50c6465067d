// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>

#include "gui/look/clip_planes.h"
#include "gui/look/landmark_input.h"
#include "gui/look/slice_geometry.h"
#include "gui/look/surface_values.h"
#include "image/intensity_range.h"
#include "image/object_axes.h"
#include "session/scene.h"

namespace simplexseg {

enum class Tool {
  Crosshair,
  ZoomPan,
  Point,
  Seed,
  Inside,
  Outside,
  Brush,
  Eraser,
  Box,
  Freeze,
  Ruler,
  Angle,
  Ellipse,
  Range
};
inline bool paints(Tool tool) { return tool == Tool::Brush || tool == Tool::Eraser || tool == Tool::Freeze; }
/// Whether a left drag draws a rectangle.
inline bool draws_box(Tool tool) { return tool == Tool::Box || tool == Tool::Range; }
inline bool measures(Tool tool) { return tool == Tool::Ruler || tool == Tool::Angle || tool == Tool::Ellipse; }

/// Volume rendering in the 3D view. Shaded: composited, with opacity from window and level, lit by the gradient.
enum class VolumeMode { Off, Shaded, Maximum };

/// Display of layers in slices: blended with the volume, instead of it in every second square, or right of a divider.
enum class LayerMode { Blend, Checkerboard, Swipe };

/// State of the display, shared by all views. It is neither saved nor part of undo.
struct ViewState {
  Eigen::Vector3d crosshair_mm{0, 0, 0};
  double window = 1, level = 0.5;  ///< intensities level -+ window/2 are black and white
  bool low_is_bright = false;      ///< inverted grey scale, as in MONOCHROME1 of DICOM
  Convention convention = Convention::Radiological;
  Tool tool = Tool::Crosshair;
  double brush_mm = 1;                          ///< radius of the brush of Brush, Eraser and Freeze
  bool brush_3d = false;                        ///< ball instead of a disc in the slice; lasso through the volume
  bool lasso = false;                           ///< contour that encloses voxels, instead of a brush
  bool local_marks = false;                     ///< new points, strokes and lassos change the object only near them
  bool smart_brush = false;                     ///< Brush and Eraser: only voxels with the intensities of the path
  std::optional<IntensityRange> range_preview;  ///< intensities that are tinted in the slices; none: nothing is
  bool window_level_armed = false;              ///< the next left drag sets window and level
  bool show_meshes = true;
  bool show_fill = false;   ///< fill of all meshes in the slices
  bool show_field = false;  ///< field of the active mesh in the slices
  bool show_annotations = true;
  bool show_layers = true;
  bool layer_contrast_armed = false;  ///< the next left drag sets window and level of the active layer
  LayerMode layer_mode = LayerMode::Blend;
  double swipe = 0.5;       ///< place of the divider of Swipe, share of the width of a slice view
  ItemId active_layer = 0;  ///< layer that the panel Layers edits; 0: none
  LandmarkInput landmarks;  ///< of a registration
  bool show_slices_3d = true;
  ClipState clip;                                       ///< planes that cut the 3D view
  VolumeMode volume_mode = VolumeMode::Off;             ///< volume in the 3D view
  bool show_names = true;                               ///< names of patient and series
  std::shared_ptr<const SurfaceValues> surface_values;  ///< colouring of the meshes in 3D; null: colour of each mesh
  float opacity = 1;                                    ///< factor on the opacity of the meshes, 0..1
  ItemId active_mesh = 0;                               ///< 0: none
  ItemId selected_point = 0;
  ItemId hovered_point = 0;  ///< point under the mouse; 0: none
  int neighbour_step = 1;    ///< distance of neighbouring slices from the slice through the crosshair, slices
  bool show_axes = false;    ///< long and short axis of the visible meshes in the slices
  std::shared_ptr<const std::map<ItemId, ObjectAxes>> object_axes;  ///< axes, as measured last; null: not measured
  ItemId hovered_measurement = 0;
  ItemId last_measurement = 0;  ///< measurement that was selected last
  /// Selected measurement; 0: none, also while a point is selected.
  ItemId selected_measurement() const { return selected_point ? 0 : last_measurement; }
};

/// Point in a shown slice, mm: the crosshair, or its neighbour along the normal by neighbour_step slices. `neighbour`:
/// 0 the slice through the crosshair, -1 the previous one, 1 the next one; it can lie outside the volume.
Eigen::Vector3d slice_through_mm(const ViewState& view, const VolumeGeometry& geometry, Orientation orientation,
                                 int neighbour);

}  // namespace simplexseg
