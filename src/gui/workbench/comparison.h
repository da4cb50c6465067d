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

/// Two settings of one mesh, tried on the same start beside each other: two copies of a scene in which the mesh goes
/// back to where it began and all others are locked. Both run at once, each for the same time in each round; what is
/// looked at and the points that are placed are the same on both sides.
class Comparison : public QObject {
  Q_OBJECT
 public:
  static constexpr int kSides = 2;
  static const char* name_of(int side) { return side == 0 ? "A" : "B"; }
  /// Of what belongs to a side: told apart by the colour-blind, and seen on a dark ground (Okabe and Ito 2008).
  static Colour colour_of(int side) { return side == 0 ? Colour{86, 180, 233} : Colour{230, 159, 0}; }

  /// Of the active mesh of `from`, which must have one. Both sides begin with its settings, and its points. Throws
  /// Error where an engine cannot be made or has not the memory.
  Comparison(const Workbench& from, const std::function<std::unique_ptr<Engine>()>& make_engine);
  ~Comparison() override;

  Workbench& side(int side) { return *sides_[side].workbench; }
  const Workbench& side(int side) const { return *sides_[side].workbench; }
  ItemId mesh() const { return mesh_; }
  /// Of the mesh that is compared, on one side.
  const MeshItem& item(int side) const;
  bool has_reference() const;

  void run();
  void pause();
  bool running() const;
  /// The mesh goes back to its start on both sides, and both run.
  void start_again();

  bool at_rest(int side) const { return sides_[side].at_rest; }
  /// Time of the simulation alone since the mesh was at its start.
  double seconds(int side) const { return sides_[side].seconds; }
  std::int64_t steps(int side) const { return sides_[side].steps; }
  /// Residual against time, or distance to the reference, where there is one: the mesh of each side in its colour.
  Plot residual_plot() const;
  Plot error_plot() const;
  /// A line for each sample of each side: setting, and then as RunTrace::csv() has it.
  std::string csv() const;

  /// What was measured of the meshes last, both at one time.
  struct Measured {
    double volume_ml = 0;
    std::optional<Agreement> agreement;  ///< with the reference
  };
  const std::optional<Measured>& measured(int side) const { return sides_[side].measured; }
  /// Dice of the voxels in the one mesh and in the other.
  std::optional<double> overlap() const { return overlap_; }

  /// A parameter that the two do not share.
  struct Difference {
    QString title;
    std::array<QString, kSides> values;
  };
  std::vector<Difference> differences() const;

 signals:
  void running_changed();
  void advanced();  ///< at least one side has moved
  void measured_anew();

 private:
  struct Side {
    std::unique_ptr<Workbench> workbench;
    RunTrace trace;
    double seconds = 0;
    double credit = 0;  ///< seconds that it has yet to be given
    std::int64_t steps = 0;
    bool at_rest = false;
    std::optional<Measured> measured;
  };

  void connect_side(int side);
  void follow_points(int side);
  void follow_view(int side);
  void follow_run(int side);
  void wake(int side);
  void tick();
  void note(int side, const Advance& done);
  void prepare_reference();
  void measure();

  ItemId mesh_;
  std::array<Side, kSides> sides_;
  BackgroundJob* job_;
  QTimer round_, pause_;
  std::shared_ptr<const SurfaceError> error_;  ///< null: not made yet, or no reference
  std::optional<double> overlap_;
  std::array<std::uint64_t, kSides> measured_revisions_{};
  bool following_ = false;  ///< a side does what the other did
};

}  // namespace simplexseg
