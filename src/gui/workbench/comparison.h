// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <QTimer>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "image/metrics.h"
#include "image/surface_error.h"
#include "session/run_trace.h"

namespace simplexseg {

class BackgroundJob;
class Engine;
class Workbench;
struct Advance;

/// Comparison of two settings for one mesh from the same start. It has two copies of the scene (sides), in which the
/// mesh is reset and all other meshes are locked. Both sides run alternately, each for the same computing time, and
/// share view and points.
class Comparison : public QObject {
  Q_OBJECT
 public:
  static constexpr int kSides = 2;
  static const char* name_of(int side) { return side == 0 ? "A" : "B"; }
  /// Colour of a side: distinguishable by the colour-blind and visible on a dark background (Okabe and Ito 2008).
  static Colour colour_of(int side) { return side == 0 ? Colour{86, 180, 233} : Colour{230, 159, 0}; }

  /// Compares settings for the active mesh of `from`, which must have one. Both sides start with the settings and
  /// points of that mesh. Throws Error when an engine is unavailable or lacks memory.
  Comparison(const Workbench& from, const std::function<std::unique_ptr<Engine>()>& make_engine);
  ~Comparison() override;

  Workbench& side(int side) { return *sides_[side].workbench; }
  const Workbench& side(int side) const { return *sides_[side].workbench; }
  ItemId mesh() const { return mesh_; }
  /// Compared mesh on one side.
  const MeshItem& item(int side) const;
  bool has_reference() const;

  void run();
  void pause();
  bool running() const;
  /// Returns true if a side runs and has not settled.
  bool moving() const;
  /// Resets the mesh on both sides, and runs both.
  void restart();

  bool settled(int side) const { return sides_[side].settled; }
  /// Computing time of the simulation since the mesh was reset, s.
  double seconds(int side) const { return sides_[side].seconds; }
  std::int64_t steps(int side) const { return sides_[side].steps; }
  /// Residual against computing time, each side in its colour.
  Plot residual_plot() const;
  /// Distance to the reference against computing time, each side in its colour; no series without a reference.
  Plot error_plot() const;
  /// Table with one line per sample and side: the setting, then the columns of RunTrace::csv().
  std::string csv() const;

  /// Latest measurements of a mesh; both sides are measured at the same time.
  struct Measured {
    double volume_ml = 0;
    std::optional<Agreement> agreement;  ///< agreement with the reference; none without one
  };
  const std::optional<Measured>& measured(int side) const { return sides_[side].measured; }
  /// Dice between the voxels of the two meshes; none before the first measurement.
  std::optional<double> overlap() const { return overlap_; }

  /// Parameter whose values differ.
  struct Difference {
    QString title;
    std::array<QString, kSides> values;
  };
  std::vector<Difference> differences() const;

 signals:
  void running_changed();
  void advanced();  ///< a round of steps has ended
  void measured_changed();

 private:
  struct Side {
    std::unique_ptr<Workbench> workbench;
    RunTrace trace;
    double seconds = 0;
    double credit = 0;  ///< remaining computing time, s; negative after steps that took longer
    std::int64_t steps = 0;
    bool settled = false;
    std::optional<Measured> measured;
  };

  void connect_side(int side);
  void follow_points(int side);
  void follow_view(int side);
  void follow_run(int side);
  void resume(int side);
  void tick();
  void record(int side, const Advance& done);
  void prepare_reference();
  void measure();

  ItemId mesh_;
  std::array<Side, kSides> sides_;
  BackgroundJob* job_;
  QTimer round_, pause_;
  std::shared_ptr<const SurfaceError> error_;  ///< null: not computed yet, or no reference
  std::optional<double> overlap_;
  std::array<std::uint64_t, kSides> measured_revisions_{};
  bool following_ = false;  ///< a side repeats an action of the other
};

}  // namespace simplexseg
