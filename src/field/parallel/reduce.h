// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "core/atomics.h"

namespace simplexseg {

/// Atomic minimum and maximum; a preceding read avoids most atomic operations.
SIMPLEXSEG_HD void lower(int* at, int value) {
  if (value < load_relaxed(at)) atomic_min(at, value);
}
SIMPLEXSEG_HD void raise(int* at, int value) {
  if (value > load_relaxed(at)) atomic_max(at, value);
}

}  // namespace simplexseg
