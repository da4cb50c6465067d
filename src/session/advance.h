// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace simplexseg {

/// Result of advancing the simulation.
struct Advance {
  int steps = 0;
  double seconds = 0;
  bool at_rest = false;               ///< whether every mesh has settled; steps change nothing until the scene changes
  std::vector<std::string> cuts;      ///< one message for each reduction of a timestep, before which steps were undone
  std::vector<std::string> warnings;  ///< one message for each new field that spreads, is probably wrong or
                                      ///< failed, or whose range has no effect or excludes its seed
  /// Message that names segmentation and force if no smaller timestep prevents a failure; none: no failure. The failed
  /// steps were undone but are counted in `steps`; the caller should pause the run.
  std::optional<std::string> failure;
  bool refined = false;  ///< whether a mesh was refined or rebuilt from its field
};

/// Adds the result `next` of the advance after `total` to `total`. Sums steps and seconds, appends the messages, and
/// takes at_rest and failure from `next`.
void append(Advance& total, const Advance& next);

}  // namespace simplexseg
