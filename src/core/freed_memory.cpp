// SPDX-License-Identifier: Apache-2.0
#include "core/freed_memory.h"

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace simplexseg {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int mib = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * mib);
  mallopt(M_TRIM_THRESHOLD, 256 * mib);
#endif
}

}  // namespace simplexseg
