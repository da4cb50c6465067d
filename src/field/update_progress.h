// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <utility>

namespace simplexseg {

/// Phases of a pass over the box of an evidence field, in their order. Constraints: image of the box, constraint mask.
/// CoarsePrior: appearance, geodesic distances, random walker on blocks. Features: networks, interpolation. Walker:
/// random walker on cells, object mask. Surface: narrow band. Output: values for the mesh, after the update.
enum class FieldPhase { Constraints, CoarsePrior, Features, Walker, Surface, Output };

/// Share of each phase in the time of a pass, from timings of a liver at 0.7 mm on one CPU thread.
constexpr std::array<float, 6> kPhaseShares{0.12f, 0.06f, 0.15f, 0.46f, 0.15f, 0.06f};

/// Receiver of the completed fraction of a computation, 0 to 1.
using ReportProgress = std::function<void(float fraction)>;

/// Completed fraction of an update; it never decreases. The box may grow several times: each pass takes a part of the
/// remaining range.
class UpdateProgress {
 public:
  /// Starts at 0. `report` may be empty; it is called on the thread of the update.
  void start(ReportProgress report) {
    report_ = std::move(report);
    fraction_ = from_ = 0;
    range_ = 1;
  }
  /// Begins a pass. `last`: the box is not expected to grow after it.
  void begin_pass(bool last) {
    constexpr float kGrowingShare = 0.25f;  // of the remaining range
    from_ = fraction_;
    range_ = (last ? 1 : kGrowingShare) * (1 - from_);
  }
  /// Reports that all earlier phases and `part` (0 to 1) of this one are completed.
  void advance(FieldPhase phase, float part = 1) {
    const auto p = static_cast<std::size_t>(phase);
    float done = std::clamp(part, 0.0f, 1.0f) * kPhaseShares[p];
    for (std::size_t earlier = 0; earlier < p; ++earlier) done += kPhaseShares[earlier];
    const float fraction = std::min(from_ + range_ * done, 1.0f);
    if (!(fraction > fraction_)) return;
    fraction_ = fraction;
    if (report_) report_(fraction);
  }

 private:
  ReportProgress report_;
  float fraction_ = 0, from_ = 0, range_ = 1;
};

}  // namespace simplexseg
