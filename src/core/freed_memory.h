// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

/// Makes the allocator keep freed blocks of up to 32 MiB for reuse, 256 MiB in total, instead of returning them to the
/// system. The system would clear them again page by page, which cost a third of the time of a field update (arrays of
/// a few megabytes). Call it first in main(). No effect without glibc.
void keep_freed_memory();

}  // namespace simplexseg
