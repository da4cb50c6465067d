// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QElapsedTimer>
#include <QObject>
#include <QTimer>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gui/look/surface_values.h"
#include "image/metrics.h"
#include "image/object_axes.h"
#include "image/surface_error.h"
#include "image/surface_fit.h"
#include "session/scene.h"

namespace simplexseg {

class BackgroundJob;
class Workbench;

/// Measurements of one mesh.
struct MeshCheck {
  ItemId mesh = 0;
  std::string name;
  double volume_ml = 0, area_cm2 = 0;
  std::optional<ObjectAxes> axes;      ///< long and short axis; none if no slice cuts the mesh
  std::optional<Intensities> inside;   ///< none if the mesh contains no voxel centre
  std::optional<Agreement> agreement;  ///< none without a reference
  /// Places farthest from the reference; from the image edges without a reference or with Colours::Image.
  std::vector<SurfaceLocation> worst;
};

/// Measures the meshes in the background, with pauses, while the simulation continues. While results or colours are
/// shown, measures again whenever meshes, poses or references have changed.
class MeshChecker : public QObject {
  Q_OBJECT
 public:
  enum class Colours { Own, Reference, Image };

  explicit MeshChecker(Workbench& workbench, QObject* parent);

  /// Sets whether the results are visible.
  void set_watched(bool watched);
  Colours colours() const { return colours_; }
  /// Sets the colouring of the meshes in the 3D view, and keeps it up to date.
  void set_colours(Colours colours);
  const std::vector<MeshCheck>& checks() const { return checks_; }
  /// Result of a mesh; null before its first check.
  const MeshCheck* of(ItemId mesh) const;
  /// Moves the crosshair to the worst place (MeshCheck::worst) of the active mesh, after a check if necessary. Further
  /// calls for the unchanged mesh move it to the next worst place.
  void go_to_worst();

 signals:
  void checked();

 private:
  struct Result;
  using ErrorMaps = std::map<std::pair<std::string, double>, std::shared_ptr<const SurfaceError>>;

  void changed();
  void check_if_due();
  void begin();
  void store(const Result& result);
  void show_colours(const Result& result);
  void show_worst();
  bool up_to_date() const;
  /// Whether results are shown or requested.
  bool is_needed() const;

  Workbench& workbench_;
  BackgroundJob* job_;
  QTimer pause_;
  QElapsedTimer took_;
  bool watched_ = false, worst_requested_ = false;
  Colours colours_ = Colours::Own;
  std::vector<MeshCheck> checks_;
  std::uint64_t checked_revision_ = ~std::uint64_t{0}, running_revision_ = 0;
  Colours checked_colours_ = Colours::Own;
  ErrorMaps maps_;  ///< distance maps of the references measured so far
  ItemId shown_mesh_ = 0;
  std::size_t shown_place_ = 0;
  std::uint64_t shown_revision_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
