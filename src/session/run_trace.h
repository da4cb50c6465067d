// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/surface_error.h"
#include "session/plot.h"
#include "session/scene.h"

namespace simplexseg {

class Session;

/// What was measured of a mesh at one time of a run.
struct TraceSample {
  double seconds;  ///< that the simulation took since the trace began
  std::int64_t steps;
  int vertices;
  double residual_mm, mean_move_mm;           ///< as in StepOutcome
  std::optional<SurfaceError::Values> error;  ///< where the mesh has a reference
};
struct MeshTrace {
  ItemId mesh;
  std::string name;
  Colour colour;
  std::vector<TraceSample> samples;
};

enum class TraceAxis { Seconds, Steps };

/// Error and residual of each mesh over the time of a run. Samples are taken every few steps; when there are too many,
/// every second one goes and they are taken half as often, so that a trace of any length stays small.
class RunTrace {
 public:
  /// `most_samples`: 2 at least.
  explicit RunTrace(int most_samples = 200);

  /// The truth of one mesh; null: none. Shared, for it is large.
  void set_reference(ItemId mesh, std::shared_ptr<const SurfaceError> reference);
  /// Whether the next sample is to be taken now.
  bool due(std::int64_t steps) const { return steps >= next_; }
  /// At least 1.
  int steps_until_due(std::int64_t steps) const {
    return static_cast<int>(std::clamp<std::int64_t>(next_ - steps, 1, 1 << 20));
  }
  /// Measures all meshes. `seconds`: time of the simulation alone, that of earlier samples not counted. Reads poses
  /// back only where a mesh has a reference.
  void sample(const Session& session, double seconds);
  /// Forgets the samples, not the references.
  void clear();
  /// Forgets the samples of meshes that the scene does not have.
  void keep(const Scene& scene);

  const std::vector<MeshTrace>& meshes() const { return meshes_; }
  /// Null for a mesh that was never sampled.
  const MeshTrace* of(ItemId mesh) const;
  bool has_errors() const;

  /// Residual of each mesh, on a log axis; a mark where the mesh was refined.
  Plot residual_plot(TraceAxis axis = TraceAxis::Seconds) const;
  /// Mean (solid) and 95th percentile (dashed) of the surface error of each mesh that has a reference.
  Plot error_plot(TraceAxis axis = TraceAxis::Seconds) const;
  /// A line for each sample: mesh, seconds, steps, vertices, residual_mm, mean_move_mm, error_mean_mm, error_p95_mm,
  /// error_max_mm (the last three empty without a reference).
  std::string csv() const;

 private:
  static constexpr int kFirstInterval = 10;  // steps; sessions decide on rest and refinement as often

  void thin();

  int most_;
  std::int64_t next_ = 0, interval_ = kFirstInterval;
  std::map<ItemId, std::shared_ptr<const SurfaceError>> references_;
  std::vector<MeshTrace> meshes_;
};

/// A field of a line of CSV (RFC 4180): quoted where it must be.
std::string csv_field(const std::string& text);

}  // namespace simplexseg
