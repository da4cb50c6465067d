// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace simplexseg {

/// For a program to call first: memory that is freed in blocks of up to 32 MiB is kept for the next that is asked for,
/// 256 MiB at most, instead of being given back to the system, which hands it out again page by page, cleared: a third
/// of the time of learning a field, which works in arrays of a few megabytes. Nothing elsewhere than with glibc.
void keep_freed_memory();

}  // namespace simplexseg
