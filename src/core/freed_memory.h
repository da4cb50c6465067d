// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

/// Makes the allocator keep freed blocks of up to 32 MiB for reuse, with up to 256 MiB of free memory at the top of the
/// heap, instead of returning them to the system. The system would clear the pages of each new block, which took a
/// third of the time of a field update (arrays of a few megabytes). Call this function first in main(). No effect
/// without glibc.
void keep_freed_memory();

}  // namespace simplexseg
