// SPDX-License-Identifier: Apache-2.0
#include "session/advance.h"

namespace simplexseg {

void append(Advance& total, const Advance& next) {
  total.steps += next.steps;
  total.seconds += next.seconds;
  total.at_rest = next.at_rest;
  total.cuts.insert(total.cuts.end(), next.cuts.begin(), next.cuts.end());
  total.warnings.insert(total.warnings.end(), next.warnings.begin(), next.warnings.end());
  total.failure = next.failure;
  total.refined = total.refined || next.refined;
}

}  // namespace simplexseg
