// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <iosfwd>

namespace simplexseg {

/// Runs the headless program `simplexseg-cli SUBCOMMAND ...`. Writes results to `out` and everything else to `err`.
/// Returns the exit status: 0; 1 = failed; 2 = invalid usage or input. A failure is one line on `err`: what happened,
/// why, what to do.
int run_cli(int argc, const char* const* argv, std::ostream& out, std::ostream& err);

}  // namespace simplexseg
