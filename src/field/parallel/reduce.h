// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/atomics.h"

namespace simplexseg {

/// Lowers, or raises, what is there; asks first, since many threads do so and few change it.
SIMPLEXSEG_HD void lower(int* at, int value) {
  if (value < load_relaxed(at)) atomic_min(at, value);
}
SIMPLEXSEG_HD void raise(int* at, int value) {
  if (value > load_relaxed(at)) atomic_max(at, value);
}

}  // namespace simplexseg
