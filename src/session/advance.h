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
  bool at_rest = false;               ///< every mesh has settled: further steps change nothing until the scene changes
  std::vector<std::string> cuts;      ///< one line per undone step after which a timestep was cut
  std::vector<std::string> warnings;  ///< one line per field that spreads, is uncertain or failed
  /// One line naming segmentation and force. The step was undone but counts as one; the run should pause.
  std::optional<std::string> failure;
  bool refined = false;  ///< the vertex counts changed
};

/// Appends `next`, which followed `total`, to it; steps and seconds are summed.
void append(Advance& total, const Advance& next);

}  // namespace simplexseg
