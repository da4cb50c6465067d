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
#include "image/surface_error.h"
#include "image/surface_fit.h"
#include "session/scene.h"

namespace simplexseg {

class BackgroundJob;
class Workbench;

/// What was found of one mesh.
struct MeshCheck {
  ItemId mesh = 0;
  std::string name;
  double volume_ml = 0, area_cm2 = 0;
  std::optional<Intensities> inside;   ///< none where it holds no voxel
  std::optional<Agreement> agreement;  ///< none without a reference
  std::vector<SurfacePlace> worst;     ///< farthest from the reference, or from the image's edges where it has none
};

/// Measures the meshes as they are, in the background and not without a pause: the run goes on meanwhile. A check is
/// made while somebody wants it, whenever meshes, poses or references have changed since the last one.
class MeshChecker : public QObject {
  Q_OBJECT
 public:
  enum class Colours { Own, Reference, Image };

  explicit MeshChecker(Workbench& workbench, QObject* parent);

  /// Whether the figures are looked at.
  void set_watched(bool watched);
  Colours colours() const { return colours_; }
  /// What the meshes are coloured by in the 3D view; kept up to date while that is not their own colours.
  void set_colours(Colours colours);
  const std::vector<MeshCheck>& checks() const { return checks_; }
  /// Null for a mesh that was not checked yet.
  const MeshCheck* of(ItemId mesh) const;
  /// Moves the crosshair to the worst place of the active mesh, and to the next worse one when it is called again
  /// before the mesh has changed. Where it has not been checked as it is, it is first.
  void go_to_worst();

 signals:
  void checked();

 private:
  struct Result;
  using ErrorMaps = std::map<std::pair<std::string, double>, std::shared_ptr<const SurfaceError>>;

  void changed();
  void consider();
  void begin();
  void take(const Result& result);
  void show_colours(const Result& result);
  void show_worst();
  bool up_to_date() const;

  Workbench& workbench_;
  BackgroundJob* job_;
  QTimer pause_;
  QElapsedTimer took_;
  bool watched_ = false, going_ = false;
  Colours colours_ = Colours::Own;
  std::vector<MeshCheck> checks_;
  std::uint64_t checked_revision_ = ~std::uint64_t{0}, running_revision_ = 0;
  Colours checked_colours_ = Colours::Own;
  ErrorMaps maps_;  ///< of references that were measured
  ItemId shown_mesh_ = 0;
  std::size_t shown_place_ = 0;
  std::uint64_t shown_revision_ = ~std::uint64_t{0};
};

}  // namespace simplexseg
