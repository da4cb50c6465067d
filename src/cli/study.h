// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "cli/commands.h"

namespace simplexseg {

// Each adds one study, in a file of its own.
void add_study_stability(CLI::App& studies, Action& action);

}  // namespace simplexseg
