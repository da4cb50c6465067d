// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <iosfwd>

namespace simplexseg {

/// The headless program: `simplexseg-cli SUBCOMMAND ...`. Results go to `out`, everything else to `err`. Returns the
/// exit status: 0; 1 = failed; 2 = bad usage or input. A failure is one line on `err`: what, why, what to do.
int run_cli(int argc, const char* const* argv, std::ostream& out, std::ostream& err);

}  // namespace simplexseg
