// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace simplexseg {

/// What an advance of the simulation did.
struct Advance {
  int steps = 0;
  double seconds = 0;
  bool at_rest = false;               ///< nothing moves any more: no need to be called again until something changes
  std::vector<std::string> cuts;      ///< one line for each step that was undone and its mesh's timestep cut
  std::vector<std::string> warnings;  ///< one line for each field that leaks, or could not be learned
  std::optional<std::string>
      failure;  ///< one line naming mesh and force; the step was undone (and counts as one), the run should pause
  bool refined = false;  ///< the vertex counts have changed
};

/// Makes of `total` what it and `next`, which came after it, did together; seconds are added up.
void append(Advance& total, const Advance& next);

}  // namespace simplexseg
