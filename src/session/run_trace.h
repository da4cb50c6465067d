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

/// Measurements of a mesh at one time of a run.
struct TraceSample {
  double seconds;  ///< time of the simulation, as given to sample()
  std::int64_t steps;
  int vertices;
  double residual_mm, mean_move_mm;           ///< measurements of the last step, see StepOutcome
  std::optional<SurfaceError::Values> error;  ///< present if the mesh has a reference
};
struct MeshTrace {
  ItemId mesh;
  std::string name;
  Colour colour;
  std::vector<TraceSample> samples;
};

enum class TraceAxis { Seconds, Steps };

/// Error and residual of each mesh over a run, sampled every few steps. If a mesh has more than the largest number of
/// samples, every second sample of all meshes is dropped and the interval doubles, which bounds the size of the trace.
class RunTrace {
 public:
  /// `max_samples`: largest number of samples per mesh, at least 2.
  explicit RunTrace(int max_samples = 200);

  /// Sets the reference surface of a mesh; null removes it.
  void set_reference(ItemId mesh, std::shared_ptr<const SurfaceError> reference);
  /// Whether the next sample is due after a total of `steps` steps.
  bool due(std::int64_t steps) const { return steps >= next_; }
  /// Number of steps until the next sample, at least 1. `steps`: total number of steps so far.
  int steps_until_due(std::int64_t steps) const {
    return static_cast<int>(std::clamp<std::int64_t>(next_ - steps, 1, 1 << 20));
  }
  /// Adds a sample of every mesh. `seconds`: time of the simulation, excluding the time of sampling. Downloads poses
  /// only if a mesh has a reference.
  void sample(const Session& session, double seconds);
  /// Removes the samples, but not the references.
  void clear();
  /// Removes the samples of meshes that are not in the scene.
  void remove_deleted(const Scene& scene);

  const std::vector<MeshTrace>& meshes() const { return meshes_; }
  /// Samples of a mesh; null for a mesh that was never sampled.
  const MeshTrace* of(ItemId mesh) const;
  bool has_errors() const;

  /// Plot of the residual of each mesh on a log axis, with a marker at each refinement.
  Plot residual_plot(TraceAxis axis = TraceAxis::Seconds) const;
  /// Plot of the surface error of each mesh that has a reference: mean (solid) and 95th percentile (dashed).
  Plot error_plot(TraceAxis axis = TraceAxis::Seconds) const;
  /// CSV with one line per sample: mesh, seconds, steps, vertices, residual_mm, mean_move_mm, error_mean_mm,
  /// error_p95_mm, error_max_mm (the last three empty without a reference).
  std::string csv() const;

 private:
  static constexpr int kFirstInterval = 10;  // steps; equals kCheckInterval of a session

  void thin();

  int max_samples_;
  std::int64_t next_ = 0, interval_ = kFirstInterval;
  std::map<ItemId, std::shared_ptr<const SurfaceError>> references_;
  std::vector<MeshTrace> meshes_;
};

/// Text as one field of a CSV line, quoted if necessary (RFC 4180).
std::string csv_field(const std::string& text);

}  // namespace simplexseg
